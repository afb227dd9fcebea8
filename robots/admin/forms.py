"""The form of a robot in the admin, with fields for the settings that the robot's spec declares."""

from collections.abc import Iterable
from typing import Any

from django import forms
from django.core.validators import MaxValueValidator, MinValueValidator
from django.forms.fields import InvalidJSONInput
from django.utils.translation import gettext, gettext_lazy

from robots.kit.contract.capabilities import Setting
from robots.kit.contract.errors import RobotError
from robots.kit.contract.find import function, spec_of, spec_or_none
from robots.kit.contract.ranges import plain
from robots.kit.contract.spec import TURN
from robots.kit.installed import drivers, simulators
from robots.models import Robot
from robots.sentences import translate

PREFIX = "setting_"  # so that no setting can replace a field that all robots have
TURNS = ("turn_s",)
RECORDING = ("records", "recordings_keep_days", "recordings_limit_mb")


class ListField(forms.JSONField):
    """A setting that is a list: JSON, which the robot's own function checks.

    It also refuses JSON that is nested too deeply or has numbers of thousands of digits.
    """

    def __init__(self, setting: Setting, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._setting = setting

    def to_python(self, value: Any) -> Any:
        """Return the parsed value. Raises ValidationError."""
        try:
            return super().to_python(value)
        except (ValueError, RecursionError) as error:
            raise forms.ValidationError(gettext("Write a list as JSON.")) from error

    def clean(self, value: Any) -> Any:
        """Return the value to be stored. Raises ValidationError."""
        found = super().clean(value)
        return check_list(self._setting, found) if found else None

    def bound_data(self, data: Any, initial: Any) -> Any:
        """Return the value that the form shows again."""
        try:
            return super().bound_data(data, initial)
        except (ValueError, RecursionError):
            return InvalidJSONInput(data)


def check_list(setting: Setting, value: Any) -> Any:
    """Return a list as the robot's own check returns it. Raises ValidationError."""
    try:
        return function(setting.check)(value)
    except RobotError as error:
        raise forms.ValidationError(translate(error)) from error


def _accepted(setting: Setting, value: Any) -> Any:
    """Return a stored list as the check returns it; None if the check refuses it."""
    try:
        return check_list(setting, value)
    except forms.ValidationError:
        return None


def _number(setting: Setting) -> forms.Field:
    low, high, unit = setting.low, setting.high, translate(setting.unit)
    words = gettext("Write a number from {low} to {high}, or leave it empty.")
    refused = words.format(low=plain(low), high=f"{plain(high)} {unit}".strip())
    label, about, default = translate(setting.label), translate(setting.help), ""
    if setting.default is not None:
        default = gettext("Empty: {value}.").format(value=f"{setting.default:.4g} {unit}".strip())
    return forms.FloatField(
        required=False, label=f"{label} ({unit})" if unit else label, help_text=f"{about} {default}".strip(),
        error_messages={"invalid": refused},
        validators=[MinValueValidator(low, refused), MaxValueValidator(high, refused)],
    )  # fmt: skip


def _list(setting: Setting) -> forms.Field:
    widget = forms.Textarea(attrs={"data-editor": setting.editor} if setting.editor else {})
    return ListField(
        setting, required=False, label=translate(setting.label), help_text=translate(setting.help), widget=widget
    )


def settings_of(driver: str) -> tuple[Setting, ...]:
    """Return the settings that the robot's spec declares; none if its package is not installed."""
    spec = spec_or_none(driver)
    return spec.settings() if spec else ()


def turns_of(driver: str) -> tuple[str, ...]:
    """Return the names of the fields for turns; empty if the robot has no command for people with a turn."""
    spec = spec_or_none(driver)
    return () if spec and not any(command.open_to(TURN) for command in spec.commands) else TURNS


def names(settings: Iterable[Setting], kind: str) -> tuple[str, ...]:
    """Return the names of the fields for the settings of that kind."""
    return tuple(PREFIX + setting.name for setting in settings if setting.kind == kind)


def _driver_field(present: str, label: Any) -> forms.ChoiceField:
    """Return the choice of installed drivers; the row's present one is in it even if its package is gone."""
    installed = drivers()
    gone = (
        [(present, gettext("{driver} (not installed)").format(driver=present))]
        if present and present not in installed
        else []
    )
    return forms.ChoiceField(
        label=label,
        choices=[*gone, *((name, name) for name in installed)],
        help_text=gettext_lazy("The robots whose packages are installed."),
        error_messages={
            "invalid_choice": gettext_lazy("There is no driver named %(value)s here; install its package and restart.")
        },
    )


class RobotForm(forms.ModelForm):  # type: ignore[type-arg]
    """A robot's row; the driver must be installed."""

    declared: tuple[Setting, ...] = ()

    class Meta:
        model = Robot
        fields = (
            "name", "slug", "tagline", "story", "clearance_required", "cheers", "practice_for", "guest_s", "driver",
            "address", "camera", "microphone", *TURNS, *RECORDING,
        )  # fmt: skip

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        if "driver" in self.fields:  # not for staff who may only look
            label = self.fields["driver"].label
            self.fields["driver"] = _driver_field(self.instance.driver if self.instance.pk else "", label)
        for setting in self.declared:
            empty: list[Any] | None = [] if setting.kind == "list" else None
            self.initial[PREFIX + setting.name] = self.instance.settings.get(setting.name, empty)

    def clean(self) -> dict[str, Any]:
        """Refuse a new driver that is not installed or broken.

        It is not loaded here; the test of the connection loads it.
        """
        cleaned = super().clean() or {}
        if "driver" not in cleaned:  # its field shows the error
            return cleaned
        if cleaned["driver"] == self.initial.get("driver") and cleaned["driver"] not in drivers():
            return cleaned  # its package is gone; the rest of the row can be changed meanwhile
        try:
            spec_of(cleaned["driver"])
        except LookupError as error:
            raise forms.ValidationError({"driver": translate(error)}) from error
        _check_simulator(cleaned["driver"], cleaned.get("address", ""))
        return cleaned

    def save(self, commit: bool = True) -> Any:
        """Save the row with the settings of the form; settings of another driver stay, in case it is chosen again."""
        written = {setting.name: self.cleaned_data.get(PREFIX + setting.name) for setting in self.declared}
        kept = self.instance.settings | written
        for setting in settings_of(self.instance.driver):  # the driver may have changed
            if setting.kind == "list" and kept.get(setting.name):
                kept[setting.name] = _accepted(setting, kept[setting.name])
        self.instance.settings = {name: value for name, value in kept.items() if value is not None}
        return super().save(commit)


def _check_simulator(driver: str, address: str) -> None:
    """Refuse a simulator that is not installed, or that speaks as another robot. Raises ValidationError."""
    kind, _, name = address.partition(":")
    if kind != "sim":
        return
    installed = simulators()
    if name not in installed:
        listed = ", ".join(f"sim:{one}" for one in installed)
        text = gettext("There is no simulator {name!r}. Installed are: {simulators}.")
        raise forms.ValidationError({"address": text.format(name=name, simulators=listed)})
    if name != driver and driver in installed:
        text = gettext("The simulator {name!r} speaks as another robot than {driver!r}. Write sim:{driver}.")
        raise forms.ValidationError({"address": text.format(name=name, driver=driver)})


def form_for(robot: Robot) -> type[RobotForm]:
    """Return the form with fields for what the robot's spec declares."""
    declared = settings_of(robot.driver)
    fields = {PREFIX + s.name: _list(s) if s.kind == "list" else _number(s) for s in declared}
    return type("RobotForm", (RobotForm,), {"declared": declared, **fields})
