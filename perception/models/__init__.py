"""Networks: clips (T, N, C, H, W) float32 in, logits (N,) out; see ``perception.registry``."""
