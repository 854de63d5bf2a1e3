"""The same sweep on many machines: blocks as tasks of Dask."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from legspring.blocks import block_of
from legspring.checks import shown
from legspring.parallel import Processes
from legspring.plans import Plan
from legspring.stores import Block, InMemory, Layout, OnDisk

if TYPE_CHECKING:
    from distributed import Client

LOG = logging.getLogger("legspring")
T = TypeVar("T")
RETRIES = 5
"""How often a block is begun again whose worker was lost."""
AHEAD = 4
"""Blocks that are handed out for each thread at a time."""


@contextmanager
def client_of(cluster: Any, workers: int) -> Iterator["Client"]:
    """Yield a client: of a cluster of processes of this machine's, of an address, or one that there is.

    Raises
    ------
    ImportError
        If Dask is missing.
    ValueError
        If it is none of these, or does not answer.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise ImportError("cluster: needs Dask; install it with: pip install 'legspring[cluster]'") from None
    if isinstance(cluster, Client):
        yield cluster
        return
    if cluster == "local":
        with LocalCluster(n_workers=workers, threads_per_worker=1) as local, Client(local) as client:
            say_where(client)
            yield client
        return
    if not isinstance(cluster, str) or "://" not in cluster:
        raise ValueError(f"cluster = {shown(cluster)}: must be local, an address as tcp://10.0.0.1:8786, or a client")
    try:
        client = Client(cluster, timeout=10)
    except (OSError, TimeoutError):
        raise ValueError(f"cluster = {shown(cluster)}: no scheduler answers there") from None
    with client:
        say_where(client)
        yield client


def say_where(client: "Client") -> None:
    """Say where a cluster can be watched at work, if it can."""
    if client.dashboard_link:
        LOG.info("Dask's dashboard: %s", client.dashboard_link)


class Elsewhere(Processes):
    """The threads of a cluster, in the place of processes."""

    def __init__(self, client: "Client") -> None:
        super().__init__(max(1, sum(client.nthreads().values())))
        self.client = client

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """Call a function on the cluster."""
        result: T = self.client.submit(function, *arguments, retries=RETRIES, pure=False).result()
        return result

    def map(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]]) -> Iterator[T]:
        """Call a function, which may use `call`, here with each of some tuples of arguments; results in their order."""
        return self._threads.map(lambda task: function(*task), tasks)


@contextmanager
def on_dask(cluster: Any, workers: int) -> Iterator[Elsewhere]:
    """Yield what stands for processes on a cluster (see `client_of`)."""
    with client_of(cluster, workers) as client:
        shared = Elsewhere(client)
        try:
            yield shared
        finally:
            shared.close()


def on_cluster(
    cluster: Any,
    workers: int,
    plan: Plan,
    layout: Layout,
    todo: Sequence[Block],
    result: InMemory | OnDisk,
    tick: Callable[[int], None],
) -> None:
    """Have blocks worked on by a cluster, and write each here as soon as it is done."""
    if not todo:
        return
    with client_of(cluster, workers) as client:
        from distributed import as_completed

        rest = list(todo)[::-1]
        names: dict[Any, Block] = {}

        def submitted() -> Any:
            block = rest.pop()
            # Each block brings all that it needs: what workers share is gone when they are.
            future = client.submit(block_of, plan.part(layout.where(block)), retries=RETRIES, pure=False)
            names[future] = block
            return future

        count = AHEAD * max(1, sum(client.nthreads().values()))
        futures = as_completed([submitted() for _ in range(min(count, len(rest)))])
        for future in futures:
            block = names.pop(future)
            result.write(block, layout.shaped(block, future.result()))
            tick(layout.count(block))
            if rest:
                futures.add(submitted())
