"""The default solver of roughcontact on tensors of torch, and one for GPUs that hardly wait for their hosts."""

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TorchFFT
from roughcontact_torch.masked import MaskedConjugateGradient
from roughcontact_torch.on_device import solve_on_device
from roughcontact_torch.processes import Processes
from roughcontact_torch.slab_arrays import SlabTensor
from roughcontact_torch.slab_contact import Contacts
from roughcontact_torch.together import solve_at_once

ending_all = Processes.ending_all
make_heights = Contacts.make_heights
solve_on_slabs = Contacts.solve

__all__ = [
    "MaskedConjugateGradient",
    "Processes",
    "SlabTensor",
    "TensorArray",
    "TorchFFT",
    "ending_all",
    "make_heights",
    "solve_at_once",
    "solve_on_device",
    "solve_on_slabs",
]
