from .drive_choice import DriveChoice as DriveChoice
from .drive_choice import TriedDrive as TriedDrive
from .drive_choice import choose_drive as choose_drive
from .motors import read_motors as read_motors
