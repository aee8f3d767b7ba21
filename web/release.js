// When a recording begins and ends: a release far above the background, then rest.

/** The background before a release is known from so much of the record, s. */
const LISTEN_S = 0.3;
/** Kept from before the release, s. */
const BEFORE_S = 0.2;
/** A block this much above the background is a release. */
const RELEASE = 6;
/** So much below the largest block, or down to the background, is rest. */
const REST = 0.004;

/** Watches samples `[time_s, ...values]` of any sensor. */
export class Release {
  /**
   * @param {object} limits
   * @param {number} limits.block_s length over which the size of the motion is told
   * @param {number} limits.rest_s so long at rest ends the recording
   * @param {number} limits.most_s the longest recording
   */
  constructor({ block_s, rest_s, most_s }) {
    this.block_s = block_s;
    this.rest_s = rest_s;
    this.most_s = most_s;
    this.begin_s = 0;
    /** @type {number[][]} */
    this.rows = [];
    /** @type {"waiting" | "recording" | "done"} */
    this.state = "waiting";
    this.background = Infinity;
    this.largest = 0;
    /** @type {number[][]} */
    this.block = [];
    /** @type {number | null} */
    this.quiet_s = null;
    /** @type {number | null} */
    this.first_s = null;
  }

  /** Takes a sample; the state is `waiting`, `recording` or `done`. @param {number[]} row */
  add(row) {
    if (this.state === "done") return this.state;
    const time_s = row[0];
    this.first_s ??= time_s;
    this.rows.push(row);
    this.block.push(row);
    if (time_s - this.block[0][0] >= this.block_s) {
      this.judge(spread(this.block), time_s);
      this.block = [];
    }
    if (this.state === "waiting") {
      // Only what comes shortly before a release is kept.
      while (this.rows.length > 4096 && time_s - this.rows[0][0] > 4 * BEFORE_S + this.block_s) this.rows.splice(0, 1024);
    } else if (time_s - this.begin_s > this.most_s) {
      this.state = "done";
    }
    return this.state;
  }

  /** @param {number} size @param {number} time_s */
  judge(size, time_s) {
    if (this.state === "waiting") {
      const listened = time_s - (this.first_s ?? time_s) > LISTEN_S;
      if (listened && size > RELEASE * Math.max(this.background, 1e-9)) {
        this.state = "recording";
        this.begin_s = time_s - this.block_s;
        this.rows = this.rows.filter(([t]) => t >= this.begin_s - BEFORE_S);
        this.largest = size;
      } else {
        this.background = Math.min(this.background, Math.max(size, 0));
      }
      return;
    }
    this.largest = Math.max(this.largest, size);
    const rest = size < Math.max(2 * this.background, REST * this.largest);
    if (!rest) this.quiet_s = null;
    else if (this.quiet_s === null) this.quiet_s = time_s;
    else if (time_s - this.quiet_s >= this.rest_s) this.state = "done";
  }

  /** Seconds recorded. */
  get seconds() {
    return this.state === "waiting" || !this.rows.length ? 0 : this.rows[this.rows.length - 1][0] - this.rows[0][0];
  }
}

/** The largest standard deviation of a column in these rows. @param {number[][]} rows */
function spread(rows) {
  let largest = 0;
  for (let column = 1; column < rows[0].length; column++) {
    let sum = 0;
    let squares = 0;
    for (const row of rows) {
      sum += row[column];
      squares += row[column] * row[column];
    }
    const mean = sum / rows.length;
    largest = Math.max(largest, squares / rows.length - mean * mean);
  }
  return Math.sqrt(Math.max(0, largest));
}

/** Rows as the text of a file, times from zero. @param {string[]} headers @param {number[][]} rows */
export function csv(headers, rows) {
  const begin = rows[0][0];
  const line = (/** @type {number[]} */ [time, ...values]) => [Number((time - begin).toFixed(7)), ...values.map((v) => Number(v.toPrecision(7)))].join(",");
  return `${headers.join(",")}\n${rows.map(line).join("\n")}\n`;
}
