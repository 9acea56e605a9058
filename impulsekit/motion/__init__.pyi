from .sensitivity import Sensitivity as Sensitivity
from .simulate import simulate as simulate
from .status import MotionStatus as MotionStatus
from .trajectory import Trajectory as Trajectory
