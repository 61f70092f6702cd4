import pytest

from ao2viz import AO2
from tests.store.hostile import Parts


@pytest.fixture(scope="session")
def agent() -> AO2:
    agent = AO2("CartPole-v1", seed=1, warmup_steps=100).learn(600)
    agent.record_episode(1)
    agent.record_episode(2)
    return agent


@pytest.fixture(scope="session")
def file(agent, tmp_path_factory):
    path = tmp_path_factory.mktemp("agents") / "cart pole.ao2"
    agent.save(path)
    return path


@pytest.fixture
def parts(file) -> Parts:
    return Parts.of(file)
