"""The look of a page: judged at both widths and in both themes, and stored as pictures."""

from itertools import product

WIDTH = "document.documentElement.scrollWidth"
SIZES = {"desktop": (1440, 900), "phone": (390, 844)}


def looks(one, name, folder):
    """Judge the page that a visitor has open: no part is cut off at its right, and axe finds nothing."""
    page = one.page
    for (size, (width, height)), theme in product(SIZES.items(), ("light", "dark")):
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=theme)
        page.wait_for_timeout(300)
        assert page.evaluate(WIDTH) <= width, f"{name}, {size}"
        one.axe(f"{name}, {size}, {theme}")
        page.evaluate("scrollTo(0, 0)")
        page.screenshot(path=folder / f"{name}-{size}-{theme}.png", full_page=True)
