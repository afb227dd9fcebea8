/** Stop stays on the screen: where its place has scrolled away, it hangs over the foot of the page. */

const MARGIN = "-72px 0px 0px 0px"; // a notice may lie over the head of the page

const place = document.querySelector<HTMLElement>(".stop-place");
const button = place?.querySelector<HTMLElement>('[data-command="stop"]');
if (place && button) {
  const seeing = new IntersectionObserver(
    ([seen]) => button.classList.toggle("afloat", seen !== undefined && seen.boundingClientRect.width > 0 && seen.intersectionRatio < 1),
    { rootMargin: MARGIN, threshold: [0, 1] },
  );
  // it is told of crossings only; a place that appears below the screen crosses nothing
  new ResizeObserver(() => {
    seeing.unobserve(place);
    seeing.observe(place);
  }).observe(place);
}
