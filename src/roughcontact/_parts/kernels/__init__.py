"""Influence kernels: the displacement of the surface by a pressure, and by shear."""

from roughcontact._parts.kernels.base import BoundKernel as BoundKernel
from roughcontact._parts.kernels.base import InfluenceKernel as InfluenceKernel
from roughcontact._parts.kernels.base import SupportsCoefficients as SupportsCoefficients
from roughcontact._parts.kernels.base import SupportsRows as SupportsRows
from roughcontact._parts.kernels.base import SupportsShear as SupportsShear
from roughcontact._parts.kernels.base import SupportsSpectrum as SupportsSpectrum
from roughcontact._parts.kernels.base import kernels as kernels
from roughcontact._parts.kernels.base import knows_own_rows as knows_own_rows
from roughcontact._parts.kernels.base import missing_form as missing_form
from roughcontact._parts.kernels.base import odd_axes as odd_axes
from roughcontact._parts.kernels.base import require_form as require_form
from roughcontact._parts.kernels.half_space import FourierHalfSpace as FourierHalfSpace
from roughcontact._parts.kernels.half_space import Love as Love
from roughcontact._parts.kernels.stress import BoundStress as BoundStress
from roughcontact._parts.kernels.stress import HalfSpaceStress as HalfSpaceStress
from roughcontact._parts.kernels.stress import SupportsConduction as SupportsConduction
from roughcontact._parts.kernels.stress import SupportsStress as SupportsStress
from roughcontact._parts.kernels.stress import SupportsTangential as SupportsTangential
from roughcontact._parts.kernels.stress import has_layers as has_layers
from roughcontact._parts.kernels.stress_cells import STRESS_COMPONENTS as STRESS_COMPONENTS
