from ..design.fit import Fit as Fit
from ..design.fit import Measurement as Measurement
from ..design.fit import fit_impacts as fit_impacts
from .calibration import Calibration as Calibration
from .calibration import calibrate as calibrate
from .columns import RecordingFormat as RecordingFormat
from .comparison import LawCandidate as LawCandidate
from .comparison import LawComparison as LawComparison
from .comparison import compare_laws as compare_laws
from .found_impacts import FoundImpact as FoundImpact
from .found_impacts import FoundImpacts as FoundImpacts
from .identification import Identification as Identification
from .identification import identify as identify
from .impact_detection import find_impacts as find_impacts
from .measurement_files import load_measurements as load_measurements
from .mirrored_axes import MirroredAxes as MirroredAxes
from .mirrored_axes import find_mirrored as find_mirrored
from .motions import MotionFit as MotionFit
from .motions import fit_motion as fit_motion
from .reading import load_recordings as load_recordings
from .recording import Recording as Recording

__all__: list[str]
