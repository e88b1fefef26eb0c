"""Convolvers: displacement from pressure, for each boundary of the domain."""

from roughcontact._solve.convolvers.base import ConvolutionSetup as ConvolutionSetup
from roughcontact._solve.convolvers.base import Convolver as Convolver
from roughcontact._solve.convolvers.base import PreparedConvolution as PreparedConvolution
from roughcontact._solve.convolvers.base import ShearConvolution as ShearConvolution
from roughcontact._solve.convolvers.base import convolvers as convolvers
from roughcontact._solve.convolvers.base import mixed_spectrum as mixed_spectrum
from roughcontact._solve.convolvers.base import periodic_spectrum as periodic_spectrum
from roughcontact._solve.convolvers.base import prepare_once as prepare_once
from roughcontact._solve.convolvers.base import wrapped_spectrum as wrapped_spectrum
from roughcontact._solve.convolvers.direct import Direct as Direct
from roughcontact._solve.convolvers.fft import DCFFT as DCFFT
from roughcontact._solve.convolvers.fft import CircularFFT as CircularFFT
from roughcontact._solve.convolvers.field_passes import FieldPasses as FieldPasses
from roughcontact._solve.convolvers.field_passes import LastStep as LastStep
from roughcontact._solve.convolvers.inverse import InverseConvolution as InverseConvolution
from roughcontact._solve.convolvers.matrix import WaveMatrix as WaveMatrix
from roughcontact._solve.convolvers.softened import SoftenedConvolution as SoftenedConvolution
from roughcontact._solve.convolvers.stress import StressConvolution as StressConvolution
from roughcontact._solve.convolvers.transforms import list_all_waves as list_all_waves
from roughcontact._solve.convolvers.transforms import padded_shape as padded_shape
