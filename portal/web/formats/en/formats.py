"""How dates and times are shown where a template says nothing else, as in the admin's lists: with seconds."""

DATE_FORMAT = "j M Y"
TIME_FORMAT = "H:i:s"
DATETIME_FORMAT = "j M Y, H:i:s"
