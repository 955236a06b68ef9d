"""Networks: clips (T, N, C, H, W) float32 in, logits (N,) out; build them by name with ``perception.registry``."""
