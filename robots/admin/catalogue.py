"""Admin pages for staff: add, test, enable, stop and lock out robots, and run their procedures."""

from typing import Any

from django.contrib import admin, messages
from django.core.exceptions import PermissionDenied
from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404, redirect, render
from django.urls import URLPattern, path
from django.utils.html import format_html
from django.utils.safestring import SafeString
from django.utils.translation import gettext, gettext_lazy

from robots import bus, grants, services
from robots.admin.bases import FormFieldsAdmin, back_to
from robots.admin.forms import RECORDING, TURNS, RobotForm, form_for, names, settings_of, turns_of
from robots.admin.links import links_about
from robots.admin.verbs import AFTER_ADDING, VERBS, settings_by_staff
from robots.kit import addresses
from robots.kit.clock import SYSTEM
from robots.kit.contract import procedures
from robots.kit.contract.capabilities import ArmModel, Calibration
from robots.kit.contract.errors import RobotError
from robots.kit.contract.find import spec_or_none
from robots.kit.packets import Changed
from robots.kit.plain import whole
from robots.models import Command, Incident, Robot
from robots.once import once
from robots.sentences import in_digits, translate
from robots.services import probes, programs
from robots.services.permissions import NotStaff
from robots.services.status import status_of
from robots.states import GrantKind

SETTINGS, CONNECTION = gettext_lazy("Settings"), gettext_lazy("Connection")  # groups of fields


@admin.register(Robot)
class RobotAdmin(FormFieldsAdmin):
    """One page a robot."""

    form = RobotForm
    search_fields = ("name", "slug")
    list_display = ("name", "state", "address", "simulated", "switched", "stop", "calibrated_at")
    prepopulated_fields = {"slug": ("name",)}
    readonly_fields = ("state", "reason", "switched", "lockout_note")
    actions = ("load_brought", "add_twins")
    also_saved = ("settings",)
    change_form_template = "admin/robots/robot/change_form.html"
    fieldsets = (
        (None, {"fields": ("name", "slug", "tagline", "story", "clearance_required", "cheers")}),
        (gettext_lazy("Practice"), {"fields": ("practice_for", "guest_s"), "classes": ("collapse",)}),
        (CONNECTION, {"fields": ("driver", "address", "camera", "microphone")}),
        (SETTINGS, {"fields": TURNS}),
        (gettext_lazy("Recording"), {"fields": RECORDING}),
        (gettext_lazy("State"), {"fields": ("switched", "state", "reason", "lockout_note")}),
    )

    @admin.display(description=gettext_lazy("Simulated"), boolean=True)
    def simulated(self, robot: Robot) -> bool:
        """Return whether a simulator answers in place of the robot."""
        return robot.simulated

    @admin.display(description=gettext_lazy("State"))
    def state(self, robot: Robot) -> str:
        """Return the robot's state in the words of its card."""
        return translate(status_of(robot, SYSTEM.now())[1])

    @admin.display(description=gettext_lazy("Switched"), ordering="enabled")
    def switched(self, robot: Robot) -> str:
        """Return whether staff have switched it on."""
        return gettext("on") if robot.enabled else gettext("off")

    @admin.display(description=gettext_lazy("Stop"), ordering="stop_latched")
    def stop(self, robot: Robot) -> SafeString | str:
        """Return that the robot is stopped, in red, because the robot does not move until it is released."""
        return format_html('<b class="farhand-bad">{}</b>', gettext("Stopped")) if robot.stop_latched else "-"

    def get_urls(self) -> list[URLPattern]:
        """Add the status part and the verbs."""
        view = self.admin_site.admin_view
        return [
            path("<int:pk>/status/", view(self.status), name="robots_robot_status"),
            path("<int:pk>/do/<str:verb>/", view(self.do), name="robots_robot_do"),
            *super().get_urls(),
        ]

    def status(self, request: HttpRequest, pk: int) -> HttpResponse:
        """Return the live part of the page."""
        robot = get_object_or_404(Robot, pk=pk)
        if not self.has_view_permission(request, robot):
            raise PermissionDenied
        return render(request, "admin/robots/robot/status.html", self._status(robot, request.user))

    def _status(self, robot: Robot, user: Any) -> dict[str, Any]:
        lease = grants.lease_of(robot)
        incidents = Incident.objects.filter(robot=robot, closed_at=None)
        commands = Command.objects.filter(robot=robot).select_related("robot")
        return {
            "robot": robot, "label": status_of(robot, SYSTEM.now())[1],
            "lease": lease, "alive": grants.owner_alive(lease, SYSTEM.now()), "link": bus.alive(),
            "grant": grants.open_grant(robot), "frame": services.newest_still(robot), "now": SYSTEM.now(),
            "stop": services.stop_shown(robot, SYSTEM.now()),
            "incidents": incidents[:5] if user.has_perm("robots.view_incident") else None,
            "commands": commands[:8] if user.has_perm("robots.view_command") else None,
            "probe_lost": probes.is_lost(robot, SYSTEM.now()),
            "readings": robot.readings(lease.state) if lease else (),
            **self._offered(robot),
        }  # fmt: skip

    @staticmethod
    def _offered(robot: Robot) -> dict[str, Any]:
        """Return what the robot's spec offers to staff; nothing if its package is not installed."""
        try:
            spec = robot.spec()
        except LookupError:
            return {"procedures": (), "settings_by_staff": (), "calibrates": False}
        calibration = spec.capability(Calibration)
        rows = calibration.result_rows(robot.calibration) if calibration else ()
        return {
            "procedures": procedures.procedures(spec), "settings_by_staff": settings_by_staff(spec),
            "calibrates": calibration is not None, "calibration": rows,
        }  # fmt: skip

    def save_model(self, request: HttpRequest, obj: Robot, form: Any, change: bool) -> None:
        """Save the row; a new robot gets what its package brings."""
        super().save_model(request, obj, form, change)
        if change:
            bus.publish_on_commit(obj.slug, Changed("robot"))  # open pages show some of it
        else:
            for told in self._load(obj):
                messages.info(request, told)

    @staticmethod
    def _load(robot: Robot) -> list[str]:
        """Load what the robot's package brings; return what staff should know."""
        programs.load_gallery(robot, SYSTEM.now())
        return [told for load in AFTER_ADDING if (told := load(robot))]

    @admin.action(description=gettext_lazy("Load what the packages bring: programs, questions"), permissions=["change"])
    def load_brought(self, request: HttpRequest, queryset: Any) -> None:
        """Load what the packages of the chosen robots bring now, for robots that were added before."""
        for robot in queryset:
            try:
                for told in self._load(robot):
                    messages.info(request, f"{robot}: {told}")
            except ImportError:
                words = gettext("{robot}: there is no driver named {driver!r}; install its package.")
                messages.error(request, words.format(robot=robot, driver=robot.driver))

    @admin.action(description=gettext_lazy("Add a simulator for practice"), permissions=["change"])
    def add_twins(self, request: HttpRequest, queryset: Any) -> None:
        """Add to each of the chosen robots a simulator on which people practise."""
        for robot in queryset:
            try:
                twin = services.add_twin(robot, request.user)
                messages.success(request, f"{robot}: people practise on {twin.get_absolute_url()}.")
            except RobotError as error:
                messages.error(request, str(error))

    def get_form(self, request: HttpRequest, obj: Robot | None = None, change: bool = False, **kwargs: Any) -> Any:
        """Return the form, for a saved robot with the settings that its spec declares."""
        form = form_for(obj) if obj is not None else RobotForm
        return super().get_form(request, obj, change, **{"form": form, **kwargs})

    def get_fieldsets(self, request: HttpRequest, obj: Robot | None = None) -> Any:
        """Return the form's groups, with the settings that the robot's spec declares."""
        if obj is None:
            return self.fieldsets
        if not self.has_change_permission(request, obj):
            shown = {
                SETTINGS: (*turns_of(obj.driver), "settings_shown"),
                CONNECTION: ("driver", "address", "camera_shown", "microphone_shown"),
            }
            return tuple((t, {"fields": shown[t]} if t in shown else o) for t, o in self.fieldsets)
        declared = settings_of(obj.driver)
        of_lists = tuple((translate(s.label), {"fields": names([s], "list")}) for s in declared if s.kind == "list")
        groups: list[Any] = []
        for title, options in self.fieldsets:
            if title is SETTINGS:
                plain = (*names(declared, "number"), *turns_of(obj.driver))
                groups += [*([(title, {"fields": plain})] if plain else []), *of_lists]
            else:
                groups.append((title, options))
        return tuple(groups)

    @admin.display(description=gettext_lazy("Set by staff"))
    def settings_shown(self, robot: Robot) -> str:
        """Return the settings as text, for staff who may only look."""
        told = [(translate(s.label), robot.settings.get(s.name), s.unit) for s in settings_of(robot.driver)]
        known = [(label, in_digits(value), unit) for label, value, unit in told if value is not None]
        return "; ".join(f"{label}: {value} {unit}".strip() for label, value, unit in known) or "-"

    @admin.display(description=gettext_lazy("Camera"))
    def camera_shown(self, robot: Robot) -> str:
        """Return the cameras' addresses without their passwords, for staff who may only look."""
        return addresses.redacted(robot.camera) or "-"

    @admin.display(description=gettext_lazy("Microphone"))
    def microphone_shown(self, robot: Robot) -> str:
        """Return the microphone's address without its password, for staff who may only look."""
        return addresses.redacted(robot.microphone) or "-"

    def do(self, request: HttpRequest, pk: int, verb: str) -> HttpResponse:
        """Run one verb, sent by POST."""
        robot = get_object_or_404(Robot, pk=pk)
        back = back_to(request, "admin:robots_robot_change", pk)
        if request.method != "POST" or verb not in VERBS:
            return back
        try:
            return once(self._carry_out)(request, robot, verb)
        except NotStaff as error:
            raise PermissionDenied(translate(error)) from error
        except RobotError as error:
            messages.error(request, translate(error))
            return back

    def _carry_out(self, request: HttpRequest, robot: Robot, verb: str) -> HttpResponse:
        messages.success(request, VERBS[verb](robot, request))
        self.log_change(
            request, robot, f"{verb} {request.POST.get('kind') or request.POST.get('note', '')}".strip()[:200]
        )
        grant = services.open_grant(robot) if verb == "maintenance" else None
        drives = grant is not None and grant.kind == GrantKind.STAFF  # else the robot comes to rest first
        return redirect(robot) if drives else back_to(request, "admin:robots_robot_change", robot.pk)

    def change_view(
        self, request: HttpRequest, object_id: str, form_url: str = "", extra_context: dict[str, Any] | None = None
    ) -> HttpResponse:
        """Show the status above the form."""
        robot = Robot.objects.filter(pk=whole(object_id) or 0).first()
        if robot is not None and not self.has_view_permission(request, robot):
            raise PermissionDenied
        extra = {**(extra_context or {}), **(self._status(robot, request.user) if robot else {})}
        extra["more"] = links_about(robot, request) if robot is not None else ()
        spec = spec_or_none(robot.driver) if robot is not None else None
        if robot is not None and spec is not None and spec.capability(ArmModel) is not None:
            from robots.kit.arms.described import model_facts  # noqa: PLC0415 - arrays, which only an arm needs

            extra["model_facts"] = model_facts(robot.driver, f"{robot.get_absolute_url()}model.urdf")
        return super().change_view(request, object_id, form_url, extra)
