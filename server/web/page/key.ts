// The dialog that asks for a bearer key.
import { isKey } from "./api/client.js";
import { complainAt, find } from "./dom.js";

export interface KeyStore {
  key: string;
}

export class KeyDialog {
  private readonly dialog = find("#key-dialog", HTMLDialogElement);
  private readonly input = find("#key", HTMLInputElement);
  private readonly reason = find("#key-reason", HTMLElement);
  private readonly error = find("#key-error", HTMLElement);
  private readonly opener = find("#key-button", HTMLElement);
  private settle: (given: boolean) => void = () => undefined;

  /** `store` is a function because the store and this dialog need each other. */
  constructor(private readonly store: () => KeyStore) {
    find("#key-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      const key = this.input.value.trim();
      this.complain(key === "" || isKey(key) ? "" : "A key consists of letters without accents, digits and signs, without spaces: remove all other characters.");
      if (!isKey(key)) return this.input.focus();
      this.keep(key);
    });
    find("#key-forget", HTMLElement).addEventListener("click", () => this.keep(""));
    find("#key-cancel", HTMLElement).addEventListener("click", () => this.dialog.close());
    // The event comes late, when the next question may be open.
    this.dialog.addEventListener("close", () => {
      if (!this.dialog.open) this.settle(false);
    });
    this.opener.addEventListener("click", () => void this.open("Requests carry it as a bearer key."));
  }

  /** True: there is a new key to try. */
  ask(): Promise<boolean> {
    const had = this.store().key !== "";
    return this.open(had ? "The key is unknown, expired or disabled." : "Enter your key for this service.");
  }

  /** Marks the button if requests carry a key. */
  refresh(): void {
    const set = this.store().key !== "";
    this.opener.classList.toggle("set", set);
    this.opener.textContent = set ? "Key: set" : "Key";
  }

  private open(reason: string): Promise<boolean> {
    this.settle(false);
    this.reason.textContent = reason;
    this.input.value = "";
    this.complain("");
    if (!this.dialog.open) this.dialog.showModal();
    this.input.focus();
    return new Promise((resolve) => (this.settle = resolve));
  }

  private complain(message: string): void {
    complainAt(this.input, this.error, message);
  }

  private keep(key: string): void {
    this.store().key = key;
    this.refresh();
    this.settle(key !== "");
    this.settle = () => undefined;
    this.dialog.close();
  }
}
