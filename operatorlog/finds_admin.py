"""Admin pages of finds: a moderator decides which piece it is; staff hide the pieces again."""

from math import hypot
from typing import Any

from django import forms
from django.contrib import admin, messages
from django.core.exceptions import PermissionDenied
from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect
from django.template.response import TemplateResponse
from django.urls import URLPattern, path, reverse
from django.utils.formats import number_format
from django.utils.html import format_html
from django.utils.safestring import SafeString
from django.utils.translation import gettext, gettext_lazy, pgettext_lazy

from operatorlog import finds
from operatorlog.errors import LogError
from operatorlog.models import Find, Piece, Round
from robots.admin.bases import GuardedAdmin, NamedInline, thumbnail
from robots.admin.links import about
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import RobotError
from robots.models import Robot
from robots.once import once
from robots.sentences import english, translate


def _cm(length: float) -> str:
    return number_format(round(length, 1), 1)


class PieceChoice(forms.ModelChoiceField):  # type: ignore[type-arg]
    """Pieces with how far each is from the place of the find."""

    find: Find | None = None

    def label_from_instance(self, obj: Piece) -> str:
        """Return the name, and the distance where the place is known."""
        if self.find is None or obj.x is None or obj.y is None:
            return str(obj)
        away = 100 * hypot(obj.x - self.find.x, obj.y - self.find.y)
        return gettext("{piece}, {distance} cm away").format(piece=obj, distance=_cm(away))


class DecisionForm(forms.ModelForm):  # type: ignore[type-arg]
    """A moderator's decision about a find."""

    piece = PieceChoice(
        Piece.objects.none(), required=False, label=pgettext_lazy("field", "piece"), empty_label=gettext_lazy("None")
    )

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        if "piece" in self.fields and self.instance.pk:
            field: Any = self.fields["piece"]
            field.find, field.queryset = self.instance, Piece.objects.filter(round=self.instance.round_id)

    def clean(self) -> dict[str, Any]:
        """Show an error of the verb at its field."""
        cleaned = super().clean() or {}
        try:
            state = Find.State(str(cleaned.get("state")))
            cleaned["piece"] = finds.check_decision(self.instance, state, cleaned.get("piece"))
        except LogError as error:
            self.add_error("piece", translate(error))
        except ValueError:
            pass  # an unknown state: its own field shows the error
        return cleaned


@admin.register(Find)
class FindAdmin(GuardedAdmin):
    """Confirm a find as a piece, or decline it."""

    list_display = ("reported_at", "picture", "name", "author", "robot", "place", "state", "piece")
    list_select_related = ("author", "round__robot", "frame__robot", "piece")
    list_filter = ("state", "round__robot")
    form = DecisionForm
    search_fields = ("name", "author__username")
    readonly_fields = ("round", "author", "name", "place", "picture", "page", "seen_at", "reported_at")
    fields = (*readonly_fields, "state", "piece")
    actions = ("decline",)

    def has_add_permission(self, request: HttpRequest) -> bool:
        """Return False: operators report finds after their turn."""
        return False

    def save_model(self, request: HttpRequest, obj: Find, form: Any, change: bool) -> None:
        """Decide through the verb, which notes who did."""
        wanted, piece = Find.State(obj.state), form.cleaned_data.get("piece")
        finds.decide(Find.objects.get(pk=obj.pk), request.user, wanted, piece, SYSTEM.now())

    @admin.action(description=gettext_lazy("Decline"), permissions=["change"])
    def decline(self, request: HttpRequest, queryset: Any) -> None:
        """Decline the chosen finds."""
        self.act_on(
            request, queryset,
            lambda find: finds.decide(find, request.user, Find.State.DECLINED, None, SYSTEM.now()),
            gettext_lazy("Declined"), gettext_lazy("Declined before"),
        )  # fmt: skip

    @admin.display(description=gettext_lazy("Robot"))
    def robot(self, find: Find) -> str:
        """Return the robot's name."""
        return str(find.round.robot)

    @admin.display(description=pgettext_lazy("find", "Place"))
    def place(self, find: Find) -> str:
        """Return the reported place."""
        return f"x {_cm(100 * find.x)} cm, y {_cm(100 * find.y)} cm"

    @admin.display(description=gettext_lazy("Picture"))
    def picture(self, find: Find) -> SafeString | str:
        """Return the picture of the report."""
        return thumbnail(find.frame, gettext("Picture of the find {name}").format(name=find.name))

    @admin.display(description=gettext_lazy("Page"))
    def page(self, find: Find) -> SafeString:
        """Return a link to the turn, which shows all its pictures."""
        return format_html('<a href="{}">{}</a>', find.turn.get_absolute_url(), gettext("The whole turn"))


class PieceInline(NamedInline):
    """The pieces of a round; staff alone see where they are."""

    model = Piece
    extra = 0
    fields = ("name", "x", "y")


class RoundForm(forms.ModelForm):  # type: ignore[type-arg]
    """A round: the first of a robot is added, each other follows from hiding the pieces again."""

    def clean_robot(self) -> Robot:
        """Refuse a robot without hidden pieces, or with rounds."""
        robot: Robot = self.cleaned_data["robot"]
        if finds.excavation_of(robot) is None:
            raise forms.ValidationError(gettext("With this robot nothing is hidden."))
        if Round.objects.filter(robot=robot).exists():
            words = gettext("It has rounds already: choose the present one in the list, and bury again.")
            raise forms.ValidationError(words)
        return robot


class NextRoundForm(forms.Form):
    """What staff say of the next round: nothing of the old one is filled in, it stands beside."""

    puzzle = forms.CharField(
        max_length=finds.LONGEST_PUZZLE, widget=forms.Textarea(attrs={"rows": 3}), label=gettext_lazy("The new puzzle"),
        help_text=gettext_lazy("What people are asked to find out; everybody reads it."),
    )  # fmt: skip
    pieces = forms.CharField(
        widget=forms.Textarea(attrs={"rows": 10}), label=gettext_lazy("The pieces that you bury, one a line"),
        help_text=gettext_lazy("Nobody but staff reads the name of a piece before it is found."),
    )  # fmt: skip

    def __init__(self, one: Round, data: Any = None) -> None:
        super().__init__(data, initial={"puzzle": one.puzzle} if finds.was_not_made(one) else {})
        if one.robot.simulated:  # its simulator knows its pieces
            del self.fields["pieces"]

    def next_round(self) -> finds.NextRound:
        """Return what was filled in."""
        data = self.cleaned_data
        return finds.NextRound(data["puzzle"], tuple(data.get("pieces", "").splitlines()))


@admin.register(Round)
class RoundAdmin(GuardedAdmin):
    """The rounds of a robot, with the pieces of each; the page *Bury again* ends the present one."""

    list_display = ("robot", "number", "began_at", "ended_at", "begun_by", "found_pieces", "bed")
    list_select_related = ("robot", "begun_by", "command")
    list_filter = ("robot",)
    form = RoundForm
    readonly_fields = ("number", "began_at", "ended_at", "begun_by", "bed")
    fields = ("robot", *readonly_fields, "puzzle")
    inlines = (PieceInline,)
    actions = ("bury_again",)

    def get_readonly_fields(self, request: HttpRequest, obj: Round | None = None) -> Any:
        """Return what nobody changes: also the robot of a round that exists."""
        return self.readonly_fields if obj is None else (*self.readonly_fields, "robot")

    def has_delete_permission(self, request: HttpRequest, obj: Round | None = None) -> bool:
        """Return False: a round with its finds stays, as a milestone."""
        return False

    def get_inlines(self, request: HttpRequest, obj: Round | None) -> Any:
        """Return no pieces for a new round: those of a simulated robot come by themselves."""
        return () if obj is None else self.inlines

    def has_renew_permission(self, request: HttpRequest) -> bool:
        """Return whether the person may hide the pieces again."""
        return request.user.has_perm("operatorlog.renew_round")

    def save_model(self, request: HttpRequest, obj: Round, form: Any, change: bool) -> None:
        """Begin the first round through the verb; of a round that exists only the puzzle changes."""
        if change:
            obj.save(update_fields=["puzzle"])
            return
        made = finds.begin_first(obj.robot, SYSTEM.now(), request.user)
        if made is not None:
            obj.pk, obj.number, obj.began_at, obj.begun_by = made.pk, made.number, made.began_at, made.begun_by
            if obj.puzzle:
                Round.objects.filter(pk=made.pk).update(puzzle=obj.puzzle)

    def get_urls(self) -> list[URLPattern]:
        """Add the page that asks for the next round."""
        bury = self.admin_site.admin_view(once(self.bury_view))
        return [path("<int:pk>/bury/", bury, name="operatorlog_round_bury"), *super().get_urls()]

    @admin.action(description=gettext_lazy("Bury again: end the round, hide the pieces anew"), permissions=["renew"])
    def bury_again(self, request: HttpRequest, queryset: Any) -> HttpResponse | None:
        """Lead to the page that asks for the next round."""
        if queryset.count() != 1:
            messages.warning(request, gettext("Choose one round: each gets a puzzle of its own."))
            return None
        return redirect("admin:operatorlog_round_bury", queryset.get().pk)

    def bury_view(self, request: HttpRequest, pk: int) -> HttpResponse:
        """Ask for puzzle and pieces of the next round; end the present one, and begin the next."""
        if not self.has_renew_permission(request):
            raise PermissionDenied
        one = get_object_or_404(Round.objects.select_related("robot", "command"), pk=pk)
        form = NextRoundForm(one, request.POST or None)
        if one.ended_at is None and not form.is_valid():
            return self._ask(request, one, form)
        try:
            is_shown = request.POST.get("bed") == str(one.command_id or "")  # nobody has buried again since
            done = (
                is_shown
                and one.ended_at is None
                and finds.bury_again(one, request.user, form.next_round(), SYSTEM.now())
            )
        except RobotError as error:
            form.add_error(None, translate(error))
            return self._ask(request, one, form)
        if done:
            self.log_change(request, one, english(gettext_lazy("Buried again")))
            messages.success(request, gettext("Buried again: the next round has begun."))
        else:
            messages.info(request, gettext("Over before, or its bed is being made: nothing was changed."))
        present = finds.present_round(one.robot) or one
        return redirect("admin:operatorlog_round_change", present.pk)

    def _ask(self, request: HttpRequest, one: Round, form: NextRoundForm) -> HttpResponse:
        context = {
            **self.admin_site.each_context(request), "opts": self.opts, "title": gettext("Bury again"), "one": one,
            "form": form, "was_not_made": finds.was_not_made(one),
        }  # fmt: skip
        status = 422 if form.is_bound else 200
        return TemplateResponse(request, "admin/operatorlog/round/bury.html", context, status=status)

    @admin.display(description=gettext_lazy("Found"))
    def found_pieces(self, one: Round) -> str:
        """Return how many pieces were found of how many."""
        pieces = one.pieces.filter(finds__isnull=False).distinct().count()
        return gettext("{count} of {all}").format(count=pieces, all=one.pieces.count())

    @admin.display(description=gettext_lazy("Bed"))
    def bed(self, one: Round) -> str:
        """Return how the command that makes the bed has ended."""
        if one.command is None:
            return gettext("as it was, or by hand")
        state, reason = one.command.get_state_display(), translate(one.command.reason)
        return f"{state}: {reason}" if reason else state


@about
def bury_link(robot: Robot, request: HttpRequest) -> tuple[str, str] | None:
    """Return the link to the page that asks for the next round; None for others than staff who may do so."""
    present = finds.present_round(robot)
    if present is None or not request.user.has_perm("operatorlog.renew_round"):
        return None
    return gettext("Bury again"), reverse("admin:operatorlog_round_bury", args=[present.pk])
