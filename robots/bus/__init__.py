"""The bus: what goes over Redis between processes. Only this package names a key, a channel or a queue."""

from robots.bus.demand import *
from robots.bus.names import *
from robots.bus.publishing import *
from robots.bus.reader import *
from robots.bus.shots import *
from robots.bus.store import *
from robots.bus.streams import *
from robots.bus.visitors import *
