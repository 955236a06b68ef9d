"""Pedestrians as tables of primitives in local coordinates; the kernels know none of their names."""

from __future__ import annotations

import numpy as np

__all__ = ["BODY_CAPSULES", "clothing"]

# joints of the posed body (kernels.pose): indices into its array
(PELVIS, CHEST, NECK, HEAD, CROWN, L_SHOULDER, L_ELBOW, L_WRIST, L_HIP, L_KNEE, L_ANKLE, L_TOE, R_SHOULDER, R_ELBOW,
 R_WRIST, R_HIP, R_KNEE, R_ANKLE, R_TOE, L_BELLY, R_BELLY, L_CHEST, R_CHEST, NAPE, L_HAND, R_HAND, BAG_LOW, BAG_HIGH) = range(28)  # fmt: skip

# slots of clothing: 0 skin, 1 hair, 2 top, 3 trousers, 4 shoes, 5 lower sleeve, 6 coat tail (only with a coat), 7 bag (some)
# capsule: joint, joint, radius, radius (shares of the height), slot
BODY_CAPSULES = np.array(
    [
        [L_BELLY, L_CHEST, 0.058, 0.066, 2], [R_BELLY, R_CHEST, 0.058, 0.066, 2], [PELVIS, CHEST, 0.066, 0.068, 2],
        [L_HIP, R_HIP, 0.056, 0.056, 3], [L_SHOULDER, R_SHOULDER, 0.038, 0.038, 2], [CHEST, NECK, 0.050, 0.028, 2],
        [NECK, HEAD, 0.029, 0.030, 0], [HEAD, CROWN, 0.040, 0.044, 0], [NAPE, CROWN, 0.040, 0.0485, 1],
        [L_SHOULDER, L_ELBOW, 0.030, 0.025, 2], [R_SHOULDER, R_ELBOW, 0.030, 0.025, 2],
        [L_ELBOW, L_WRIST, 0.0235, 0.018, 5], [R_ELBOW, R_WRIST, 0.0235, 0.018, 5],
        [L_WRIST, L_HAND, 0.017, 0.014, 0], [R_WRIST, R_HAND, 0.017, 0.014, 0],
        [L_HIP, L_KNEE, 0.050, 0.034, 3], [R_HIP, R_KNEE, 0.050, 0.034, 3],
        [L_KNEE, L_ANKLE, 0.032, 0.023, 3], [R_KNEE, R_ANKLE, 0.032, 0.023, 3],
        [L_ANKLE, L_TOE, 0.022, 0.017, 4], [R_ANKLE, R_TOE, 0.022, 0.017, 4],
        [L_HIP, L_KNEE, 0.060, 0.036, 6], [R_HIP, R_KNEE, 0.060, 0.036, 6], [BAG_LOW, BAG_HIGH, 0.055, 0.045, 7],
    ]
)  # fmt: skip
SKINS = np.array(
    [[0.50, 0.30, 0.20], [0.42, 0.24, 0.15], [0.30, 0.16, 0.09], [0.16, 0.08, 0.045], [0.09, 0.045, 0.025]]
)
HAIRS = np.array(
    [
        [0.012, 0.010, 0.009],
        [0.04, 0.022, 0.012],
        [0.10, 0.055, 0.025],
        [0.30, 0.20, 0.09],
        [0.32, 0.31, 0.30],
    ]
)
TOPS = np.array(
    [[0.03, 0.03, 0.035], [0.08, 0.085, 0.10], [0.02, 0.05, 0.14], [0.35, 0.03, 0.03], [0.55, 0.53, 0.50], [0.50, 0.16, 0.03],
     [0.04, 0.16, 0.08], [0.52, 0.40, 0.05], [0.14, 0.10, 0.07], [0.10, 0.20, 0.35]]
)  # fmt: skip
TROUSERS = np.array(
    [
        [0.02, 0.03, 0.07],
        [0.015, 0.015, 0.017],
        [0.05, 0.08, 0.17],
        [0.22, 0.17, 0.11],
        [0.07, 0.07, 0.075],
        [0.06, 0.065, 0.03],
    ]
)
SHOES = np.array([[0.02, 0.018, 0.016], [0.5, 0.5, 0.48], [0.09, 0.045, 0.02], [0.25, 0.03, 0.03]])


def clothing(seed: int, model: int) -> np.ndarray:
    """Draw a pedestrian's colours from its seed.

    Returns:
        (8, 4): albedo r, g, b and whether the slot is worn, for each slot of ``BODY_CAPSULES``.
    """
    rng = np.random.default_rng([seed & 0xFFFFFFFF, model, 77])
    skin = SKINS[rng.integers(len(SKINS))]
    hair = HAIRS[rng.integers(len(HAIRS) - 1)] if model != 2 else HAIRS[-1]
    tone = rng.uniform(0.8, 1.2)
    top, trousers, shoes = (t[rng.integers(len(t))] for t in (TOPS, TROUSERS, SHOES))
    coat, bag, short = rng.random() < (0.25 if model != 1 else 0.1), rng.random() < 0.3, rng.random() < 0.25
    bag_colour = TOPS[rng.integers(len(TOPS))] * 0.8
    slots = np.zeros((8, 4))
    for k, colour in enumerate(
        (
            skin,
            hair,
            top * tone,
            trousers * tone,
            shoes,
            skin if short and not coat else top * tone,
            top * tone,
            bag_colour,
        )
    ):
        slots[k, :3], slots[k, 3] = np.clip(colour, 0.008, 0.7), 1.0
    slots[6, 3], slots[7, 3] = float(coat), float(bag)
    return slots
