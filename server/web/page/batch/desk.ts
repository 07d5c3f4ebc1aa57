// A batch from its link to its end: asked for, watched, cancelled.
import { batchAt, cancelBatch } from "../api/batches.js";
import { isAbort, type Client } from "../api/client.js";
import { hasEnded } from "../api/types.js";
import { watchBatch } from "../api/watch.js";
import type { Announcer } from "../dom.js";
import { lookingOf, type Looking } from "./looking.js";
import type { RowSource } from "./source.js";
import { BatchView } from "./view.js";

/** What the page around it does. */
export interface Around {
  host: HTMLElement;
  client: Client;
  announcer: Announcer;
  shown(): void; // the host is to be seen
  over(title: string, words: string): void; // there is nothing to show any more
  trouble(error: unknown): void; // beside what is shown
}

export class BatchDesk {
  private view: BatchView | null = null;
  private last: { id: string; source: RowSource } | null = null; // its rows need not be read again on the way back

  constructor(private readonly around: Around) {}

  /** Until it has ended, or until the signal. `watching`: it runs, and is seen. Throws what asking throws. */
  async open(id: string, signal: AbortSignal, watching: () => void): Promise<void> {
    const { client, host, announcer } = this.around;
    const batch = await batchAt(client, id, signal);
    const looking = lookingOf(history.state);
    const source = this.last?.id === id ? this.last.source : null;
    const remember = () => history.replaceState({ looking } satisfies { looking: Looking }, "");
    this.around.shown();
    const view = new BatchView(host, { client, batch, source, looking, remember, cancel: () => void this.cancel(id, signal), signal }, announcer);
    this.view = view;
    this.last = { id, source: view.source };
    if (hasEnded(batch)) return;
    watching();
    view.end(await watchBatch(client, id, view, signal));
  }

  // It ended between the question and the DELETE.
  private forgotten(signal: AbortSignal): void {
    if (!signal.aborted) this.around.over("Ended, and forgotten", forgotten);
  }

  // DELETE makes the service forget what has ended, so that its state is asked for first.
  private async cancel(id: string, signal: AbortSignal): Promise<void> {
    const { client, announcer } = this.around;
    try {
      const batch = await batchAt(client, id, signal);
      if (signal.aborted) return;
      if (hasEnded(batch)) {
        announcer.sayNow("It had ended already.");
        return this.view?.end(batch);
      }
      if ((await cancelBatch(client, id)) === null) this.forgotten(signal);
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      this.around.trouble(error);
      this.view?.mayCancel();
    }
  }
}

const forgotten = "The batch ended just before it was cancelled, and cancelling what has ended makes the service forget it: its link leads nowhere now.";
