// The interval over time.

export interface Sample {
  ms: number; // since the start of the comparison
  lower: number;
  upper: number | null; // null: unknown
}

const mostSamples = 500;

/** Bounds only improve, so each holds until the next one. */
export class History {
  private readonly kept: Sample[] = [];

  get samples(): readonly Sample[] {
    return this.kept;
  }

  get last(): Sample | undefined {
    return this.kept.at(-1);
  }

  add(sample: Sample): void {
    const last = this.kept.at(-1);
    if (last && sample.ms < last.ms) return; // a response that arrived after a later one
    if (last && last.lower === sample.lower && last.upper === sample.upper) return;
    this.kept.push({ ...sample });
    if (this.kept.length > mostSamples) this.thin();
  }

  // Drops every other sample of the older half; the first, the last and the recent ones stay.
  private thin(): void {
    const half = mostSamples / 2;
    const thinned = this.kept.filter((_, i) => i === 0 || i >= half || i % 2 === 0);
    this.kept.splice(0, this.kept.length, ...thinned);
  }
}

/** Returns the ends of an axis of time that grows in steps, in ms, with round numbers along it. */
export function timeAxis(ms: number): { end: number; ticks: number[] } {
  const end = [10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 30_000, 60_000, 120_000, 180_000].find((one) => ms <= one) ?? ms;
  const step = [2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 30_000, 60_000].find((one) => end / one <= 6) ?? end / 5;
  const ticks: number[] = [];
  for (let at = 0; at <= end; at += step) ticks.push(at);
  return { end, ticks };
}
