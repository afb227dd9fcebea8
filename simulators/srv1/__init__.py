"""The hall rover in its hall, in MuJoCo."""
