"""Small contacts of roughcontact in compiled code: products and passes by numba."""

from roughcontact_numba.convolver import CompiledFFT as CompiledFFT
from roughcontact_numba.passes import CompiledPasses as CompiledPasses
