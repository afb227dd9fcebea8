"""How dates and times are shown in German as `formats/en` has it in English."""

DATE_FORMAT = "j. M Y"
TIME_FORMAT = "H:i:s"
DATETIME_FORMAT = "j. M Y, H:i:s"
