"""Template tags of a robot's page: its console, and the code that leads a phone to it."""

import secrets

import segno
from django import template
from django.template import Context
from django.utils.safestring import SafeString, mark_safe

from portal.web.consoles.console import parts

register = template.Library()


@register.simple_tag(takes_context=True)
def parts_of(context: Context, console: str) -> dict[str, SafeString]:
    """Return the parts of the console's template, rendered with the page's own context."""
    engine, cut = context.template.engine, secrets.token_hex(16)  # type: ignore[union-attr]
    with context.push(cut=cut):
        found = parts(engine.get_template(console).render(context), cut)
        if not found["screen"]:  # the page cannot do without it
            found["screen"] = engine.get_template("consoles/_screen.html").render(context)
    return {name: mark_safe(text) for name, text in found.items()}  # noqa: S308 - rendered by templates, which escape


@register.simple_tag(takes_context=True)
def page_code(context: Context, fragment: str) -> SafeString:
    """Return a QR code of this page's own address with a fragment. It carries no key: who follows it has to sign in."""
    request = context["request"]
    code = segno.make(f"{request.build_absolute_uri(request.path)}#{fragment}", micro=False)
    return mark_safe(code.svg_inline(scale=4, light="#fff"))  # noqa: S308 - squares only
