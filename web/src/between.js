// What is drawn of a run between its frames, where some numbers are not there.

// a number between two frames: the earlier one's until the later, where a run has gone wrong before that
export function between(first, last, share) {
  if (share >= 1) return last;
  return share > 0 && Number.isFinite(last) ? first + share * (last - first) : first;
}

// the last node of x, y, z after x, y, z that a line has; what follows it is of runs with more nodes
export function endOf(points) {
  let end = points.length;
  while (end > 3 && !Number.isFinite(points[end - 3])) end -= 3;
  return points.slice(end - 3, end);
}
