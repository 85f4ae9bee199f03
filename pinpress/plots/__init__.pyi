from .charts import draw as draw
from .style import save as save
