/** Gives the focus to the robot's picture, where Escape stops; to the view beside it if that is shown alone. */
export function focusStage(): void {
  const screen = document.getElementById("screen"),
    view = screen?.checkVisibility() === false ? document.getElementById("stage-view") : screen;
  if (view && view !== screen) view.tabIndex = -1;
  view?.focus({ preventScroll: true });
}
