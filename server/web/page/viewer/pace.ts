// Chooses the level of detail while the picture moves. A graphics card draws everything; for software rendering the mesh gets
// coarser and the picture smaller, until a frame is fast enough. At rest everything is drawn in full.

export interface Fineness {
  scale: number; // of the picture's width and height in pixels
  coarse: 0 | 1 | 2; // of the mesh: all triangles, fewer, very few (kCoarse)
}

export const kCoarse = [Infinity, 16_000, 5_000] as const; // triangles

const kTooSlow = 90; // ms of a frame
const kEasy = 30;
const kLevels: readonly Fineness[] = [
  { scale: 1, coarse: 0 },
  { scale: 0.7, coarse: 0 },
  { scale: 0.7, coarse: 1 },
  { scale: 0.5, coarse: 1 },
  { scale: 0.5, coarse: 2 },
  { scale: 0.3, coarse: 2 },
];

export class Pace {
  private level: number;
  private readonly finest: number;
  private easy = 0;

  // For software rendering it starts coarse: the first full frame would be too slow, however fast those of the coarse mesh
  // are.
  constructor(slow: boolean, triangles: number) {
    const large = slow && triangles > 50_000;
    this.finest = large ? 2 : 0;
    this.level = large ? 4 : slow ? 1 : 0;
  }

  get moving(): Fineness {
    return kLevels[this.level]!;
  }

  // Call with the time that a frame at `moving` took.
  took(ms: number): void {
    if (ms > kTooSlow) {
      this.level = Math.min(this.level + (ms > 2 * kTooSlow ? 2 : 1), kLevels.length - 1);
      this.easy = -20; // not back at once
    } else if (ms >= kEasy) {
      this.easy = Math.min(this.easy, 0);
    } else if (++this.easy > 12 && this.level > this.finest) {
      --this.level;
      this.easy = 0;
    }
  }
}
