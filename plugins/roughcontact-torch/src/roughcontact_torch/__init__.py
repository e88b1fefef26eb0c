"""The default solver of roughcontact on tensors of torch, and a solver for which no GPU waits for its host."""

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TorchFFT
from roughcontact_torch.masked import MaskedConjugateGradient

__all__ = ["MaskedConjugateGradient", "TensorArray", "TorchFFT"]
