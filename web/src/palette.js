// Viridis (Smith & van der Walt 2015), equally bright steps that the colour-blind can tell apart,
// without the end that would vanish: the yellow on paper, the violet at night.

const VIRIDIS = [
  "440154", "482475", "414487", "355f8d", "2a788e", "21918c", "22a884", "44bf70", "7ad151",
  "bddf26", "fde725",
].map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255));

const PART = { light: [0, 0.9], dark: [0.18, 1] };

// writes the colour of a share (0 to 1) of the range into out[at..at+2]
export function colour(share, dark, out, at = 0) {
  const [low, high] = dark ? PART.dark : PART.light;
  const known = share >= 0 ? Math.min(share, 1) : 0; // a lost node has no share
  const place = (low + (high - low) * known) * (VIRIDIS.length - 1);
  const first = Math.min(Math.floor(place), VIRIDIS.length - 2);
  for (let k = 0; k < 3; k++) {
    const a = VIRIDIS[first][k];
    out[at + k] = a + (VIRIDIS[first + 1][k] - a) * (place - first);
  }
}

export function gradient(dark, way = "to right") {
  const stops = [];
  for (let k = 0; k <= 10; k++) {
    const rgb = [0, 0, 0];
    colour(k / 10, dark, rgb);
    stops.push(`rgb(${rgb.map((c) => Math.round(255 * c)).join(" ")})`);
  }
  return `linear-gradient(${way}, ${stops.join(", ")})`;
}

// what the colours span: from zero where that is near, or where all tensions are one
export function shades(low, high) {
  const near = low < 0.4 * high || high - low < 1e-6 * high;
  return [low > 0 && near ? 0 : low, high];
}
