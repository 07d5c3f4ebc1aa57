// The commands of buttons and keys; each announces its effect.
import { witnessView } from "./camera";
import type { LiveRegion } from "./dom";
import { nameOf, other, type CutAxis, type Settings, type Store, type ViewerInput } from "./settings";
import type { Stage } from "./stage";
import { length, sub, unit, type Vec3 } from "./vec";
import { atLeast, withUnits } from "./words";

const kAxes: Record<"x" | "y" | "z", Vec3> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

const kToggles = {
  wire: ["Edges are shown.", "Edges are not shown."],
  plain: ["Colours are plain, without light.", "Colours are lit."],
  split: ["Side by side; the cameras are linked.", "One picture."],
} as const;

export const cutWords = (axis: CutAxis): string => (axis === "off" ? "No cut" : `Cut across ${axis === "view" ? "the direction of view" : axis}`);

export class Commands {
  constructor(
    private readonly stage: Stage,
    private readonly store: Store,
    private readonly input: ViewerInput,
    private readonly live: LiveRegion,
  ) {}

  swap(): void {
    const coloured = other(this.now.coloured);
    this.store.set({ coloured });
    this.live.say(`${nameOf(coloured)} is coloured by its distance to ${nameOf(other(coloured))}.`);
  }

  toggle(name: keyof typeof kToggles): void {
    const value = !this.now[name];
    this.store.set({ [name]: value });
    this.live.say(kToggles[name][value ? 0 : 1]);
  }

  show(side: "a" | "b"): void {
    const shown = { ...this.now.shown, [side]: !this.now.shown[side] };
    this.store.set({ shown });
    this.live.say(`${nameOf(side)} is ${shown[side] ? "shown" : "hidden"}.`);
  }

  // "view" cuts across the current direction of view, also when pressed again.
  cut(axis: CutAxis): void {
    const pose = this.stage.eye.pose();
    const normal = axis === "view" ? unit(sub(pose.position, pose.target)) : axis === "off" ? this.now.cut.normal : kAxes[axis];
    this.store.set({ cut: { ...this.now.cut, axis, normal } });
    this.live.say(`${cutWords(axis)}.`);
  }

  nextCut(): void {
    const order: CutAxis[] = ["off", "x", "y", "z", "view"];
    this.cut(order[(order.indexOf(this.now.cut.axis) + 1) % order.length]!);
  }

  moveCut(by: number): void {
    const { cut } = this.now;
    if (cut.axis === "off") return;
    this.store.set({ cut: { ...cut, offset: Math.min(1, Math.max(-1, cut.offset + by)) } });
  }

  flipCut(): void {
    this.store.set({ cut: { ...this.now.cut, flipped: !this.now.cut.flipped } });
    this.live.say("The other side of the cut is shown.");
  }

  view(name: string): void {
    this.live.say(`Seen from ${name}.`);
    void this.stage.eye.view(name);
  }

  whole(): void {
    this.stage.eye.whole();
    this.live.say("The whole of both meshes.");
  }

  // Without an index, flies to the other witness.
  nextWitness(): Promise<void> {
    return this.witness((this.now.witness + 1) % Math.max(1, this.input.witnesses.length));
  }

  async witness(index = 0): Promise<void> {
    const witness = this.input.witnesses[index];
    if (!witness) {
      this.live.say("There is no witness: the comparison found no pair of points.");
      return;
    }
    this.store.set({ witness: index });
    const camera = this.stage.camera();
    const rect = camera.viewport;
    const view = witnessView(witness, camera, {
      aspect: rect.width / rect.height,
      context: 0.012 * this.stage.radius,
      isFree: (from, at) => this.stage.isFree(from, at),
    });
    const [one, two] = [nameOf(witness.from), nameOf(other(witness.from))];
    const apart = withUnits(atLeast(witness.lower), this.input.units);
    this.live.say(`At the witness: a point of ${one} that is at least ${apart} from ${two}.`);
    await this.stage.eye.flyTo(view);
  }

  private get now(): Settings {
    return this.store.value;
  }
}

// The label beside the segment.
export function witnessLabel(input: ViewerInput, index: number): string {
  const witness = input.witnesses[index];
  if (!witness) return "";
  const measured = witness.lower > 0 ? witness.lower : length(sub(witness.nearest, witness.point));
  return `${withUnits(atLeast(measured, 3), input.units)}, at least`;
}
