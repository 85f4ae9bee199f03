from .charts import draw as draw
from .identification import identifiability as identifiability
from .measured_vibration import measured_modes as measured_modes
from .measured_vibration import measured_spectra as measured_spectra
from .measured_vibration import order_spectra as order_spectra
from .stroke_force import measured_force as measured_force
from .style import save as save
