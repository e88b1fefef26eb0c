"""One thread of torch outside of solves: on a busy machine its threads wait for each other."""

import torch

torch.set_num_threads(1)
