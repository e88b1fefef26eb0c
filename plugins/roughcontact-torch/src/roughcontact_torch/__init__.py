"""The default solver of roughcontact on tensors of torch, and a solver for which a GPU hardly waits for its host."""

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TorchFFT
from roughcontact_torch.masked import MaskedConjugateGradient
from roughcontact_torch.on_device import TensorSolution, solve_on_device
from roughcontact_torch.together import solve_at_once

__all__ = ["MaskedConjugateGradient", "TensorArray", "TensorSolution", "TorchFFT", "solve_at_once", "solve_on_device"]
