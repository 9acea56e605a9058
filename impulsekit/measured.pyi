from .design.fit import Fit as Fit
from .design.fit import Measurement as Measurement
from .design.fit import fit_impacts as fit_impacts
from .design.measured import load_measurements as load_measurements
from .view.recording import Recording as Recording

__all__: list[str]
