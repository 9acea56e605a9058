from . import errors as errors
from .chain import chain_urdf as chain_urdf
from .chain import pendulum_urdf as pendulum_urdf
from .impact import Impact as Impact
from .impact import ImpactSolver as ImpactSolver
from .impact import Status as Status
from .impact import solve as solve
from .impact.freed import FreedJoint as FreedJoint
from .impact.freed import freed_joint as freed_joint
from .robot import Robot as Robot
from .robot.combine import combine as combine
from .robot.examples import example_names as example_names
from .scene import AppliedImpulse as AppliedImpulse
from .scene import FrameAnchor as FrameAnchor
from .scene import JointCoupling as JointCoupling
from .scene import JointImpulse as JointImpulse
from .scene import JointLock as JointLock
from .scene import PointAnchor as PointAnchor
from .scene import Scene as Scene
from .scene.points import ReportPoint as ReportPoint
from .scenefile import SceneFile as SceneFile
from .scenefile import dump_scene as dump_scene
from .scenefile import load_scene as load_scene
from .scenefile import save_scene as save_scene
from .view.report import report as report

__version__: str
