from .maps.sensitivity import Sensitivity as Sensitivity
from .record.status import MotionStatus as MotionStatus
from .record.trajectory import Trajectory as Trajectory
from .simulate import simulate as simulate
