// What the address asks for.

export type Route = { view: "form" } | { view: "comparison"; id: string } | { view: "unknown"; path: string };

export function routeOf(path: string): Route {
  if (path === "/" || path === "") return { view: "form" };
  const id = /^\/c\/([0-9a-f]{32})\/?$/.exec(path)?.[1];
  return id === undefined ? { view: "unknown", path } : { view: "comparison", id };
}

export function pathOf(id: string): string {
  return `/c/${id}`;
}
