// Parses server-sent events from a stream of bytes (HTML standard, section 9.2.6), for fetch: EventSource sends no Authorization.

export interface ServerEvent {
  name: string; // "message" if the stream names none
  data: string;
}

/** Takes text cut anywhere; returns events whose blank line has been seen. */
export class EventParser {
  private rest = "";
  private begun = false;
  private skipLineFeed = false; // the last piece ended between \r and \n
  private name = "";
  private data: string[] = [];

  push(text: string): ServerEvent[] {
    let fresh = text;
    if (!this.begun && fresh !== "") {
      this.begun = true;
      if (fresh.startsWith("\uFEFF")) fresh = fresh.slice(1);
    }
    if (this.skipLineFeed && fresh !== "") {
      this.skipLineFeed = false;
      if (fresh.startsWith("\n")) fresh = fresh.slice(1);
    }
    this.skipLineFeed ||= fresh.endsWith("\r");
    const lines = (this.rest + fresh).split(/\r\n|\r|\n/);
    this.rest = lines.pop() ?? "";
    return lines.flatMap((line) => this.take(line));
  }

  private take(line: string): ServerEvent[] {
    if (line === "") return this.dispatch();
    const colon = line.indexOf(":");
    if (colon === 0) return []; // a comment
    const field = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? "" : line.slice(colon + 1).replace(/^ /, "");
    if (field === "event") this.name = value;
    if (field === "data") this.data.push(value);
    return [];
  }

  private dispatch(): ServerEvent[] {
    const event = { name: this.name || "message", data: this.data.join("\n") };
    const empty = this.data.length === 0;
    this.name = "";
    this.data = [];
    return empty ? [] : [event];
  }
}

/** Yields the text of a body as it arrives; throws if it breaks off. */
export async function* textOf(body: ReadableStream<Uint8Array>): AsyncGenerator<string, void, undefined> {
  const reader = body.pipeThrough(new TextDecoderStream() as ReadableWritablePair<string, Uint8Array>).getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield value;
    }
  } finally {
    reader.cancel().catch(() => undefined); // a reader that stops early releases the connection
  }
}

/** Yields the events of a body; returns at its end, throws if it breaks off. */
export async function* eventsOf(body: ReadableStream<Uint8Array>): AsyncGenerator<ServerEvent, void, undefined> {
  const parser = new EventParser();
  for await (const text of textOf(body)) yield* parser.push(text);
}
