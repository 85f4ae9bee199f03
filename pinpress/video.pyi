from .visual.film import film as film
from .visual.film import image as image
from .visual.film import pdf as pdf
