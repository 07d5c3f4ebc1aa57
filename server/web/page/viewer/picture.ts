// Saves the picture as a PNG file: the canvas with the witness's label and a colour bar.
import { colourOf, css, ticks, type ColourScale, type Path } from "./colours";
import { kMarkColour } from "./marks";
import { figure, withUnits } from "./words";

export interface PictureParts {
  canvas: HTMLCanvasElement;
  ratio: number; // pixels of the canvas per CSS pixel
  labels: { x: number; y: number; text: string }[]; // CSS pixels within the canvas
  title: string;
  colours: ColourScale;
  paths: readonly Path[]; // one bar each, above each other
  units: string;
  paper: string;
  ink: string;
}

const kBar = 64; // CSS pixels below the picture

export function composed(parts: PictureParts): HTMLCanvasElement {
  const { canvas, ratio } = parts;
  const whole = document.createElement("canvas");
  whole.width = canvas.width;
  whole.height = canvas.height + Math.round(kBar * ratio);
  const paint = whole.getContext("2d");
  if (!paint) throw new Error("The browser gives no canvas for the picture.");
  paint.fillStyle = parts.paper;
  paint.fillRect(0, 0, whole.width, whole.height);
  paint.drawImage(canvas, 0, 0);
  paint.scale(ratio, ratio);
  paint.font = "600 13px system-ui, sans-serif";
  for (const { x, y, text } of parts.labels) paintLabel(paint, x, y, text);
  paintBar(paint, parts, canvas.width / ratio, canvas.height / ratio);
  return whole;
}

function paintLabel(paint: CanvasRenderingContext2D, x: number, y: number, text: string): void {
  const { width } = paint.measureText(text);
  paint.fillStyle = "#fff";
  paint.fillRect(x, y - 11, width + 14, 22);
  paint.strokeStyle = kMarkColour;
  paint.strokeRect(x, y - 11, width + 14, 22);
  paint.fillStyle = "#16181d";
  paint.fillText(text, x + 7, y + 4.5);
}

function paintBar(paint: CanvasRenderingContext2D, { colours, paths, units, title, ink }: PictureParts, width: number, top: number): void {
  const [left, size] = [16, width - 32];
  const main = colours.limited ? 0.9 * size : size;
  const high = 14 / paths.length;
  paths.forEach((path, row) => {
    for (let i = 0; i < size; ++i) {
      paint.fillStyle = css(colourOf(i < main ? (colours.top * i) / main : Infinity, colours, path));
      paint.fillRect(left + i, top + 24 + row * high, 1.5, high);
    }
  });
  paint.fillStyle = ink;
  paint.font = "12px system-ui, sans-serif";
  paint.fillText(paths.length > 1 ? `${title}: ${paths.join(" above, ")} below` : title, left, top + 16);
  const values = ticks(colours.top);
  if (colours.limited) {
    paint.textAlign = "right";
    paint.fillText("above the limit", left + size, top + 16);
  }
  values.forEach((value, i) => {
    const last = i === values.length - 1;
    paint.textAlign = i === 0 ? "left" : last ? "right" : "center";
    paint.fillText(last ? `${colours.limited ? "limit " : ""}${withUnits(figure(value), units)}` : figure(value), left + (colours.top > 0 ? (main * value) / colours.top : 0), top + 54);
  });
  paint.textAlign = "left";
}

// Downloads it as `name`.
export function save(picture: HTMLCanvasElement, name: string, failed: () => void): void {
  picture.toBlob((blob) => {
    if (!blob) return failed();
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    window.setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }, "image/png");
}
