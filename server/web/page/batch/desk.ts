// A batch from its link to its end: loads, watches and cancels it.
import { batchAt, cancelBatch } from "../api/batches.js";
import { isAbort, type Client } from "../api/client.js";
import { hasEnded } from "../api/types.js";
import { watchBatch } from "../api/watch.js";
import type { Announcer } from "../dom.js";
import { listStateOf, type ListState } from "./list_state.js";
import type { RowSource } from "./source.js";
import { BatchView } from "./view.js";

/** What the page around it does. */
export interface Around {
  host: HTMLElement;
  client: Client;
  announcer: Announcer;
  shown(): void; // show the host
  over(title: string, words: string): void; // replace the view: there is nothing to show
  trouble(error: unknown): void; // show an error beside the view
}

export class BatchDesk {
  private view: BatchView | null = null;
  private last: { id: string; source: RowSource } | null = null; // kept, so that going back does not read the rows again

  constructor(private readonly around: Around) {}

  /** Shows the batch until it has ended, or until the signal. `watching` is called when it runs and is visible. Throws as requests do. */
  async open(id: string, signal: AbortSignal, watching: () => void): Promise<void> {
    const { client, host, announcer } = this.around;
    const batch = await batchAt(client, id, signal);
    const listState = listStateOf(history.state);
    const source = this.last?.id === id ? this.last.source : null;
    const remember = () => history.replaceState({ listState } satisfies { listState: ListState }, "");
    this.around.shown();
    const view = new BatchView(host, { client, batch, source, listState, remember, cancel: () => void this.cancel(id, signal), signal }, announcer);
    this.view = view;
    this.last = { id, source: view.source };
    if (hasEnded(batch)) return;
    watching();
    view.end(await watchBatch(client, id, view, signal));
  }

  private async cancel(id: string, signal: AbortSignal): Promise<void> {
    try {
      const batch = await cancelBatch(this.around.client, id);
      if (!signal.aborted && hasEnded(batch)) this.view?.end(batch);
    } catch (error) {
      if (signal.aborted || isAbort(error)) return;
      this.around.trouble(error);
      this.view?.mayCancel();
    }
  }
}
