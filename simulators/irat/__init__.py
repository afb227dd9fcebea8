"""The iRat in its maze, in MuJoCo."""
