"""Results in the formats of other programs: ParaView, Blender, spreadsheets, MoorDyn's readers."""

from lumpedcable.export.export import FORMATS, export_result

__all__ = ["FORMATS", "export_result"]
