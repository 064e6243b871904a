// The head and the arrays of the page, as lumpedcable/page/pack.py wrote them.

export function readHead() {
  return JSON.parse(document.getElementById("head").textContent);
}

export async function readBlock() {
  const text = document.getElementById("blob").textContent.trim();
  if (!text) return new ArrayBuffer(0);
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return await new Response(stream).arrayBuffer();
}

// An array of any rank; at(i, j, ...) is its value, NaN where there is none.
export class Table {
  constructor(block, how) {
    const Kind = { f4: Float32Array, i2: Int16Array }[how.kind];
    const count = how.shape.reduce((product, size) => product * size, 1);
    this.values = new Kind(block, how.start, count);
    this.shape = how.shape;
    this.how = how;
    this.strides = how.shape.map((_, k) => how.shape.slice(k + 1).reduce((a, b) => a * b, 1));
  }

  at(...where) {
    let place = 0;
    for (let k = 0; k < where.length; k++) place += where[k] * this.strides[k];
    return this.value(place);
  }

  value(place) {
    const raw = this.values[place];
    if (this.how.kind === "f4") return raw;
    return raw === -32768 ? NaN : raw * this.how.step + this.how.middle;
  }

  // the last dimension at (run, frame), as an ordinary array
  row(...where) {
    const size = this.shape[where.length];
    let start = 0;
    for (let k = 0; k < where.length; k++) start += where[k] * this.strides[k];
    const found = new Float64Array(size);
    for (let k = 0; k < size; k++) found[k] = this.value(start + k);
    return found;
  }

  range(run) {
    const size = this.strides[0];
    let low = Infinity, high = -Infinity;
    for (let k = run * size; k < (run + 1) * size; k++) {
      const value = this.value(k);
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return [low, high];
  }
}
