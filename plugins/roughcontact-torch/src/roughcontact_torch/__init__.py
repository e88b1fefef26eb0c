"""The default solver of roughcontact on tensors of torch: a convolver, and arrays that it shares with the solver."""

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TorchFFT

__all__ = ["TensorArray", "TorchFFT"]
