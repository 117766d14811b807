"""A Dask cluster does what one process does, also while its workers die."""

from pathlib import Path

import pytest

from otolith.core.errors import InputError
from otolith.studies.cluster import Cluster
from tests.studies.test_executors import refused, squared


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cluster")


@pytest.fixture(scope="module")
def cluster(folder: Path):
    with Cluster("local", folder, workers=2) as made:
        yield made


def test_a_worker_that_dies_loses_nothing_but_its_job(cluster: Cluster, folder: Path) -> None:
    found = list(cluster.as_done(squared, range(12)))
    assert (folder / "died").exists()
    assert sorted(found) == [(k, k * k) for k in range(12)]
    assert list(cluster.as_done(squared, [])) == []


def test_errors_are_those_of_the_work(cluster: Cluster) -> None:
    with pytest.raises(InputError, match="the item is 1, must be another"):
        list(cluster.as_done(refused, [1]))


def test_an_address_where_nobody_answers_is_refused(folder: Path) -> None:
    with pytest.raises(InputError, match="must be the address of a Dask scheduler that answers"):
        Cluster("nonsense", folder)
