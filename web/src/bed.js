// The bed: as high everywhere, or a curve along x that is straight beyond its ends.

export class Bed {
  // told: a height, or { x, z, slopes }, in metres
  constructor(told) {
    const flat = typeof told === "number";
    this.x = flat ? [0] : told.x;
    this.z = flat ? [told] : told.z;
    this.slopes = flat ? [0, 0] : told.slopes;
  }

  // its height at x
  at(x) {
    const { x: places, z, slopes } = this, last = places.length - 1;
    if (x <= places[0]) return z[0] + slopes[0] * (x - places[0]);
    if (x >= places[last]) return z[last] + slopes[1] * (x - places[last]);
    const k = places.findIndex((place) => place > x) - 1;
    return z[k] + ((x - places[k]) / (places[k + 1] - places[k])) * (z[k + 1] - z[k]);
  }

  // places from x0 to x1 between which it is straight
  places(x0, x1) {
    return [x0, ...this.x.filter((x) => x > x0 && x < x1), x1];
  }

  // lowest and highest between x0 and x1
  range(x0, x1) {
    const heights = this.places(x0, x1).map((x) => this.at(x));
    return [Math.min(...heights), Math.max(...heights)];
  }
}
