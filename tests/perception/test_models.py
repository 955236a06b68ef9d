import pytest
import torch
from spikingjelly.activation_based import neuron, surrogate

from pedcross_env.errors import ConfigError
from perception.models.plif import PLIF
from perception.models.spiking import SpikingResNet18, TemporalBatchNorm, firing_rates, fresh_state
from perception.registry import NETWORKS, create_network, register_network


def small(name: str, frames: int = 3, in_channels: int = 2) -> torch.nn.Module:
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        return create_network(name, in_channels=in_channels, frames=frames, width=0.125)


def clips(frames: int = 3, count: int = 2, in_channels: int = 2) -> torch.Tensor:
    return torch.rand(frames, count, in_channels, 32, 32, generator=torch.Generator().manual_seed(1))


def with_statistics(name: str) -> torch.nn.Module:
    """Return a network whose norms know the statistics of ``clips(count=8)``."""
    network = small(name).train()
    for module in network.modules():
        if isinstance(module, torch.nn.modules.batchnorm._BatchNorm):
            module.momentum = 1.0
    with torch.no_grad(), fresh_state(network):
        network(clips(count=8))
    return network.eval()


@pytest.mark.parametrize(
    ("name", "parameters"), [("pt_resnet18", 11_170_753), ("sps_r18t", 11_170_953), ("sps_r18", 11_170_773)]
)
def test_full_width_has_the_published_number_of_parameters(name, parameters):
    network = create_network(name, in_channels=1, frames=9, width=1.0)
    assert sum(p.numel() for p in network.parameters()) == parameters


def test_parameter_names_are_those_of_torchvision():
    names = set(dict(small("pt_resnet18").named_parameters()))
    assert {
        "conv1.weight",
        "bn1.bias",
        "layer2.0.downsample.0.weight",
        "layer4.1.bn2.weight",
        "fc.bias",
    } <= names
    assert len(names) == 62


@pytest.mark.parametrize("name", list(NETWORKS))
def test_every_network_gives_one_logit_per_clip_and_a_gradient_to_every_parameter(name):
    network = small(name).train()
    with fresh_state(network):
        logits = network(clips())
        logits.sum().backward()
    assert logits.shape == (2,)
    assert all(p.grad is not None for p in network.parameters())


@pytest.mark.parametrize("name", list(NETWORKS))
def test_another_number_of_frames_is_refused(name):
    with pytest.raises(ConfigError, match="frames = 3"):
        small(name)(clips(frames=1))


def test_other_channels_and_ranks_are_refused():
    with pytest.raises(ConfigError, match="2 input channels"):
        small("sps_r18t")(clips(in_channels=1))
    with pytest.raises(ConfigError, match=r"\(T, N, C, H, W\)"):
        small("stacked_resnet18")(clips()[0])


def test_a_tebn_layer_refuses_the_single_frame_it_would_broadcast():
    norm = TemporalBatchNorm(9, 4)
    with pytest.raises(ConfigError, match="frames = 9"):
        norm(torch.rand(1, 2, 4, 5, 5))


def test_tebn_starts_as_batch_norm_and_scales_each_time_step():
    x = torch.randn(3, 2, 4, 5, 5, generator=torch.Generator().manual_seed(0))
    norm, reference = TemporalBatchNorm(3, 4), torch.nn.BatchNorm2d(4)
    expected = reference(x.flatten(0, 1)).unflatten(0, (3, 2))
    torch.testing.assert_close(norm(x), expected)
    with torch.no_grad():
        norm.scale.copy_(torch.tensor([1.0, 2.0, -3.0]))
    torch.testing.assert_close(norm(x), expected * torch.tensor([1.0, 2.0, -3.0]).view(3, 1, 1, 1, 1))


def test_fused_plif_equals_spikingjelly_forward_and_backward():
    generator = torch.Generator().manual_seed(0)
    ours = PLIF()
    theirs = neuron.ParametricLIFNode(2.0, True, 1.0, 0.0, surrogate.Sigmoid(4.0), False, "m")
    with torch.no_grad():
        ours.w.fill_(0.3)
        theirs.w.fill_(0.3)
    x = torch.randn(7, 3, 5, 4, generator=generator) * 2
    weight = torch.randn(x.shape, generator=generator)
    results = []
    for node in (ours, theirs):
        leaf = x.clone().requires_grad_()
        first = node(leaf)
        second = node(leaf.flip(0))  # carries the membrane of the first on
        (first * weight + second * weight.flip(1)).sum().backward()
        results.append((first, second, node.v, leaf.grad, node.w.grad))
    assert results[0][0].mean() > 0.05
    for mine, reference in zip(*results, strict=True):
        torch.testing.assert_close(mine, reference, rtol=1e-4, atol=1e-5)


def test_plif_in_half_precision_stays_near_full_precision():
    x = torch.randn(7, 3, 5, 4, generator=torch.Generator().manual_seed(0)) * 2
    gradients = []
    for dtype in (torch.float32, torch.bfloat16):
        leaf = x.to(torch.bfloat16).to(dtype).requires_grad_()
        spikes = PLIF()(leaf)
        spikes.sum().backward()
        assert spikes.dtype == leaf.grad.dtype == dtype
        gradients.append(leaf.grad.float())
    torch.testing.assert_close(*gradients, rtol=0.02, atol=0.02)


def test_state_does_not_leak_between_clips():
    network = small("sps_r18t_add").train()
    for module in network.modules():
        if hasattr(module, "running_mean"):
            module.momentum = 1.0  # real statistics at once: without them nothing fires
    with torch.no_grad():
        with fresh_state(network):
            network(clips())
        network.eval()
        with fresh_state(network):
            first = network(clips())
        with fresh_state(network):
            again = network(clips())
        leaked = network(clips()), network(clips())
    torch.testing.assert_close(first, again, rtol=0, atol=0)
    assert not torch.equal(*leaked)


def test_an_exception_still_resets_the_state():
    network = small("sps_r18t")

    def fire_then_fail():
        with fresh_state(network):
            network.sn1(clips())
            network(clips(frames=2))

    with pytest.raises(ConfigError):
        fire_then_fail()
    assert network.sn1.v == 0.0


def test_pseudo_temporal_is_blind_to_order_and_the_others_are_not():
    shown = clips(frames=3)
    for name, blind in (("pt_resnet18", True), ("stacked_resnet18", False), ("sps_r18_add", False)):
        network = small(name).train()
        with torch.no_grad():
            with fresh_state(network):
                forward = network(shown)
            with fresh_state(network):
                backward = network(shown.flip(0))
        assert torch.allclose(forward, backward, atol=1e-5) == blind, name


def test_iand_shortcuts_stay_binary_and_add_shortcuts_do_not():
    for connect, largest in (("iand", 1.0), ("add", None)):
        network = SpikingResNet18(2, 3, 0.125, connect=connect).train()
        seen = []
        network.layer1.register_forward_hook(lambda _m, _i, output, seen=seen: seen.append(output))
        with fresh_state(network):
            network(clips() * 3)
        values = set(seen[0].unique().tolist())
        assert values <= ({0.0, 1.0} if largest else {0.0, 1.0, 2.0, 3.0})
        assert largest or values - {0.0, 1.0}


def test_an_iand_trunk_starts_awake_and_its_branches_quiet():
    rates = firing_rates(with_statistics("sps_r18t"), clips(count=8))
    trunk = {name: rate for name, rate in rates.items() if name == "sn1" or "downsample" in name}
    branches = {name: rate for name, rate in rates.items() if name.endswith("sn2")}
    assert len(trunk) == 4
    assert all(0.08 < rate < 0.5 for rate in trunk.values()), trunk
    assert all(rate < 0.15 for rate in branches.values()), branches


def test_the_other_connections_start_as_usual():
    for name in ("sp_r18", "sps_r18t_add"):
        norms = [m for m in small(name).modules() if isinstance(m, torch.nn.modules.batchnorm._BatchNorm)]
        assert all((norm.weight == 1).all() and (norm.bias == 0).all() for norm in norms)


def test_firing_rates_name_all_layers_and_are_empty_without_spikes():
    network = small("sps_r18t")
    rates = firing_rates(network, clips())
    assert len(rates) == 20
    assert all(0 <= rate <= 1 for rate in rates.values())
    assert network.training
    assert firing_rates(small("pt_resnet18"), clips()) == {}


def test_unknown_names_and_widths_name_what_is_allowed():
    with pytest.raises(ConfigError, match="Did you mean 'sps_r18t'"):
        create_network("sps_r18tt", in_channels=1, frames=9, width=1.0)
    with pytest.raises(ConfigError, match="64 \\* width"):
        create_network("sps_r18t", in_channels=1, frames=9, width=0.3)
    with pytest.raises(ConfigError, match="already"):
        register_network("pt_resnet18", "somewhere:else")
