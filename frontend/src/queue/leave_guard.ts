/** Leaving during a turn: the browser asks, or the turn bar for a link of this site. */

export const LEAVE_EVENT = "farhand:leave";
export interface LeaveRequest {
  operating(): boolean;
  go(): void;
}

/** Ask before this page is left, for as long as `operating`. */
export function guardTurn(operating: () => boolean): void {
  let sure = false;
  addEventListener("pageshow", () => (sure = false)); // the page may come back from the browser's cache
  addEventListener("beforeunload", (event) => {
    if (operating() && !sure) event.preventDefault();
  });
  document.addEventListener("click", (event) => {
    const link = (event.target as Element).closest<HTMLAnchorElement>("a[href]");
    if (!link || event.defaultPrevented || event.button !== 0 || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
    const here = link.origin === location.origin && link.pathname === location.pathname && link.search === location.search;
    if (!operating() || sure || here || link.origin !== location.origin || (link.target && link.target !== "_self") || link.download)
      return;
    event.preventDefault();
    const go = (): void => {
      sure = true;
      location.assign(link.href);
    };
    document.dispatchEvent(new CustomEvent<LeaveRequest>(LEAVE_EVENT, { detail: { operating, go } }));
  });
}
