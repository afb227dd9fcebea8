/** Stop stays on the screen: where its place has scrolled away, it hangs over the foot of the page. */

const HEAD = 72; // px that a notice may lie over

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
  // anew when a size changes: it is told of crossings only, and a place that appears below the screen crosses nothing
  const sizes = new ResizeObserver(look);
  sizes.observe(place);
  if (bar) sizes.observe(bar);
}
