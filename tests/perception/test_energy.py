import pytest
import torch

from pedcross_env.errors import ConfigError
from perception.energy import count_energy
from perception.models.spiking import SpikingResNet18, fresh_state
from perception.registry import create_network


@pytest.mark.parametrize(("frames", "macs", "printed_macs", "printed_mj"), [
    (9, 36.835, 36.16, 166.33), (30, 122.782, 120.53, 554.42),
])  # fmt: skip
def test_the_pseudo_temporal_network_costs_what_is_known(frames, macs, printed_macs, printed_mj):
    network = create_network("pt_resnet18", in_channels=1, frames=frames, width=1.0)
    clip = torch.zeros(frames, 1, 1, 256, 450)
    energy = count_energy(network, clip)
    assert energy.macs / 1e9 == pytest.approx(macs, abs=2e-3)
    assert energy.macs / frames == pytest.approx(4.0927e9, rel=1e-4)
    assert energy.acs == 0
    assert energy.millijoules == pytest.approx(energy.macs * 4.6e-9)
    paper = count_energy(network, clip, convention="paper")
    assert round(paper.macs / 1e9, 2) == printed_macs
    assert paper.millijoules == pytest.approx(printed_mj, abs=0.01)


def test_all_but_the_first_layer_of_a_spiking_network_only_adds():
    network = create_network("sps_r18t", in_channels=1, frames=3, width=0.125).train()
    dense = create_network("pt_resnet18", in_channels=1, frames=3, width=0.125)
    clip = torch.rand(3, 1, 1, 64, 64, generator=torch.Generator().manual_seed(0))
    for module in network.modules():
        if isinstance(module, torch.nn.BatchNorm2d) or hasattr(module, "running_mean"):
            module.momentum = 1.0
    with torch.no_grad(), fresh_state(network):
        network(clip)
    energy, reference = count_energy(network, clip), count_energy(dense, clip)
    conv1, readout = 3 * 32 * 32 * 49 * 8, 3 * 64
    assert energy.macs == conv1 + readout
    assert energy.macs + energy.synapses == reference.macs
    assert 0 < energy.acs < energy.synapses
    assert energy.layers["layer1.0.conv1"][1] > 0


def test_accumulates_are_the_spikes_times_their_fan_out():
    network = SpikingResNet18(1, 2, 0.125, connect="iand").train()
    clip = torch.rand(2, 1, 1, 32, 32, generator=torch.Generator().manual_seed(0)) * 4
    with torch.no_grad(), fresh_state(network):
        for module in network.modules():
            if hasattr(module, "running_mean"):
                module.momentum = 1.0
        network(clip)
    seen = {}
    network.layer2[0].conv1.register_forward_hook(lambda _m, i, o: seen.update(x=i[0], y=o))
    network.eval()
    with torch.no_grad(), fresh_state(network):
        network(clip)
    expected = float(seen["x"].mean()) * seen["y"].numel() * 9 * seen["x"].shape[2]
    assert expected > 0
    assert count_energy(network, clip).layers["layer2.0.conv1"] == (0.0, pytest.approx(expected, rel=1e-5))


def test_energy_grows_with_the_length_of_the_clip():
    costs = []
    for frames in (3, 6):
        network = create_network("pt_resnet18", in_channels=1, frames=frames, width=0.125)
        costs.append(count_energy(network, torch.zeros(frames, 1, 1, 32, 32)).macs)
    assert costs[1] == 2 * costs[0]


def test_what_cannot_be_counted_is_refused():
    network = create_network("sps_r18", in_channels=1, frames=3, width=0.125)
    with pytest.raises(ConfigError, match="without spikes"):
        count_energy(network, torch.zeros(3, 1, 1, 32, 32), convention="paper")
    with pytest.raises(ConfigError, match="one clip"):
        count_energy(network, torch.zeros(3, 2, 1, 32, 32))
