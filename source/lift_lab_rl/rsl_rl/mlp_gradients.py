"""Forward and backward pass of a multi-layer perceptron over blocks of samples.

With networks of this size autograd spends half its time on memory. It allocates an array for every intermediate result,
and reads arrays that have left the second-level cache. Here a thread keeps its arrays, and a block is small enough for
them to stay in the cache.

A pass is one TorchScript function: torch runs it without the interpreter lock, so that threads do not wait for each
other between the operations. The operations are those of the same Python code, and so are the bits of their results.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

import torch
from torch import nn

from .torchscript import compiled

BLOCK_ROWS = 512
"""Samples in a block on a CPU: large enough for efficient matrix products, small enough for the second-level cache."""

DEVICE_BLOCK_ROWS = 1 << 15
"""Samples in a block on another device, where only the memory for intermediate results sets a limit."""


@compiled
def _elu_forward(
    x: torch.Tensor, params: list[torch.Tensor], hidden: list[torch.Tensor], spare: list[torch.Tensor]
) -> torch.Tensor:
    """Output of layers with ELU between them; ``hidden`` gets the outputs of the hidden ones."""
    for k in range(len(hidden)):
        y = torch.addmm(params[2 * k + 1], x, params[2 * k].t(), out=hidden[k])
        # elu(y) = max(y, exp(min(y, 0)) - 1)
        below = torch.clamp_max(y, 0.0, out=spare[k])
        below.exp_().sub_(1.0)
        x = torch.maximum(y, below, out=hidden[k])
    return torch.addmm(params[-1], x, params[-2].t())


@compiled
def _elu_backward(
    x: torch.Tensor,
    grad: torch.Tensor,
    params: list[torch.Tensor],
    hidden: list[torch.Tensor],
    spare: list[torch.Tensor],
    sums: list[torch.Tensor],
) -> None:
    """Add the gradients of the last forward pass to ``sums``; ``hidden`` is overwritten."""
    for after in range(len(hidden) + 1):
        k = len(hidden) - after
        inputs = hidden[k - 1] if k > 0 else x
        sums[2 * k].addmm_(grad.t(), inputs)
        sums[2 * k + 1].add_(grad.sum(0))
        if k > 0:
            by_output = torch.mm(grad, params[2 * k], out=spare[k - 1])
            # elu'(y) = 1 + min(elu(y), 0)
            grad = torch.addcmul(by_output, by_output, inputs.clamp_max_(0.0), out=inputs)


class EluMlp:
    """Forward and backward pass of a network with ELU (alpha 1) between its layers, in arrays that are reused.

    For one thread at a time. Gradients are off in here: call within ``torch.no_grad()`` or inference mode.
    """

    def __init__(self, layers: Sequence[nn.Linear]):
        """Allocate nothing yet.

        Args:
            layers: of the network, from its input to its output.
        """
        self._params = [param for layer in layers for param in (layer.weight, layer.bias)]
        self._widths = [layer.out_features for layer in layers[:-1]]
        self._rows = 0
        self._memory: list[torch.Tensor] = []
        self._arrays: dict[int, tuple[list[torch.Tensor], list[torch.Tensor]]] = {}
        self._input: torch.Tensor | None = None

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """The network's output.

        Args:
            x: shape (rows, inputs); kept until :meth:`backward`.

        Returns:
            A new tensor of shape (rows, outputs).
        """
        self._input = x
        return _elu_forward(x, self._params, *self._arrays_for(x))

    def backward(self, grad: torch.Tensor, sums: Sequence[torch.Tensor]) -> None:
        """Add the gradients of the last forward pass.

        Args:
            grad: of the loss by the output, shape (rows, outputs).
            sums: tensors to which the gradients are added, in the order of ``parameters()``: a weight, its bias, ...
        """
        assert self._input is not None
        _elu_backward(self._input, grad, self._params, *self._arrays_for(self._input), list(sums))

    def _arrays_for(self, x: torch.Tensor) -> tuple[list[torch.Tensor], list[torch.Tensor]]:
        """For each hidden layer one for its output, later its gradient, and a spare one, which all layers share."""
        rows = len(x)
        if rows not in self._arrays:
            with torch.inference_mode(False):  # arrays of inference mode could not be written to outside of it
                if rows > self._rows:
                    self._rows = rows
                    self._memory = [
                        x.new_empty(rows * width) for width in (*self._widths, max(self._widths, default=0))
                    ]
                    self._arrays.clear()
                *hidden, spare = self._memory
                self._arrays[rows] = (
                    [own[: rows * width].view(rows, width) for own, width in zip(hidden, self._widths, strict=True)],
                    [spare[: rows * width].view(rows, width) for width in self._widths],
                )
        return self._arrays[rows]


class AutogradMlp:
    """Forward and backward pass of any network, by torch's automatic differentiation."""

    def __init__(self, network: nn.Module):
        """Keep the network.

        Args:
            network: maps (rows, inputs) to (rows, outputs).
        """
        self._network = network
        self._output: torch.Tensor | None = None

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """As :meth:`EluMlp.forward`."""
        with torch.enable_grad():
            output = self._network(x)
        self._output = output
        return output.detach()

    def backward(self, grad: torch.Tensor, sums: Sequence[torch.Tensor]) -> None:
        """As :meth:`EluMlp.backward`."""
        assert self._output is not None
        grads = torch.autograd.grad(self._output, list(self._network.parameters()), grad)
        torch._foreach_add_(list(sums), grads)  # pyright: ignore[reportPrivateImportUsage]
        self._output = None


class MlpPerThread:
    """A network for any number of threads: each gets arrays of its own."""

    def __init__(self, network: nn.Sequential):
        """Look at the network.

        Args:
            network: linear layers with activations between them.
        """
        self._network = network
        self._local = threading.local()
        self._layers = [module for module in network if isinstance(module, nn.Linear)]
        between = [module for module in network if not isinstance(module, nn.Linear)]
        self.by_hand = (
            len(between) == len(self._layers) - 1
            and all(type(module) is nn.ELU and module.alpha == 1.0 for module in between)
            and all(layer.bias is not None for layer in self._layers)
        )
        """Whether the derivatives are written out here; otherwise automatic differentiation finds them."""

    def here(self) -> EluMlp | AutogradMlp:
        """The network of the calling thread."""
        own: Any = getattr(self._local, "own", None)
        if own is None:
            own = EluMlp(self._layers) if self.by_hand else AutogradMlp(self._network)
            self._local.own = own
        return own


class GradientSums:
    """Sums over samples: the gradients of a network's parameters and a few more numbers.

    Attributes:
        vector: all sums in one row, so that they are added, averaged and scaled in one call.
        grads: a view of ``vector`` for each parameter, in the shape of the parameter.
        extra: the other numbers, the last of ``vector``, shape (count,).
        weights: the part of ``vector`` that ``grads`` shows.
    """

    def __init__(self, params: Sequence[nn.Parameter], extra: int):
        """All zero.

        Args:
            params: the network's parameters.
            extra: how many other numbers.
        """
        sizes = [param.numel() for param in params]
        with torch.inference_mode(False):
            self.vector = torch.zeros(sum(sizes) + extra, dtype=params[0].dtype, device=params[0].device)
        *grads, self.extra = self.vector.split([*sizes, extra])
        self.weights = self.vector[: sum(sizes)]
        self.grads = [grad.view_as(param) for grad, param in zip(grads, params, strict=True)]
