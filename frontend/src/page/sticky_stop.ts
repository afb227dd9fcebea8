/** Keeps Stop on the screen: if its place is scrolled away, it is shown at the bottom of the window. */

const HEAD = 72; // px that a notice may cover

const place = document.querySelector<HTMLElement>(".stop-place");
const button = place?.querySelector<HTMLElement>('[data-command="stop"]');
if (place && button) {
  const bar = document.querySelector<HTMLElement>(".turnbar");
  let seeing: IntersectionObserver | null = null;
  const look = (): void => {
    seeing?.disconnect();
    seeing = new IntersectionObserver(
      ([seen]) => button.classList.toggle("afloat", seen !== undefined && seen.boundingClientRect.width > 0 && seen.intersectionRatio < 1),
      { rootMargin: `-${HEAD}px 0px -${bar?.offsetHeight ?? 0}px 0px`, threshold: [0, 1] },
    );
    seeing.observe(place);
  };
  // again when a size changes, because the observer only reports crossings
  const sizes = new ResizeObserver(look);
  sizes.observe(place);
  if (bar) sizes.observe(bar);
}
