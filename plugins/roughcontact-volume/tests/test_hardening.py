"""Yield stresses, their slopes and works; what materials refuse."""

import attrs
import numpy as np
import pytest
import roughcontact as rc

from roughcontact_volume import (
    LinearHardening,
    LudwikHardening,
    Plastic,
    SwiftHardening,
    TabulatedHardening,
    VoceHardening,
)
from roughcontact_volume.radial_return import find_multiplier

STRAINS = np.array([0.0, 1e-6, 1e-3, 0.013, 0.05, 0.4])
EACH = [
    LinearHardening(0.0),
    LinearHardening("4GPa"),
    SwiftHardening(strain=0.005, power=0.2),
    LudwikHardening("510MPa", power=0.26),
    VoceHardening("1.5GPa", strain=0.02),
    TabulatedHardening(strain=[0.01, 0.03, 0.1], stress=["1.2GPa", "1.4GPa", "1.45GPa"]),
    TabulatedHardening(strain=[0.0, 0.03], stress=["1GPa", "1.4GPa"]),
]


def make_material(hardening=None, **others):
    return Plastic("210GPa", 0.3, "1GPa", hardening, **others)


@pytest.mark.parametrize("hardening", EACH)
class TestHardening:
    def test_begins_with_the_yield_stress(self, hardening):
        assert make_material(hardening).find_yield_stress(np.zeros(2)).tolist() == [1e9, 1e9]

    def test_slope_is_the_derivative(self, hardening):
        material = make_material(hardening)
        step = 1e-7
        ahead = (material.find_yield_stress(STRAINS + step) - material.find_yield_stress(STRAINS)) / step
        # Of powers the slope falls by 1e-5 within the step.
        assert material.find_slope(STRAINS) == pytest.approx(ahead, rel=1e-4, abs=1e3)

    def test_work_is_the_integral(self, hardening):
        material = make_material(hardening)
        for strain in STRAINS:
            points = np.linspace(0.0, strain, 20_001)
            integral = np.trapezoid(material.find_yield_stress(points), points)
            assert material.find_work(strain) == pytest.approx(integral, rel=1e-6)

    def test_never_falls(self, hardening):
        assert np.all(np.diff(make_material(hardening).find_yield_stress(np.linspace(0.0, 1.0, 501))) >= 0.0)


def test_swift_and_linear_at_a_point():
    assert make_material(SwiftHardening(0.01, 0.5)).find_yield_stress(0.03) == pytest.approx(2e9)
    assert make_material("4GPa").find_yield_stress(0.1) == pytest.approx(1.4e9)
    assert make_material(EACH[5]).find_yield_stress(np.array([0.005, 0.02, 5.0])) == pytest.approx(
        [1.1e9, 1.3e9, 1.45e9]
    )


def test_a_number_is_a_modulus_and_none_is_perfect():
    assert make_material(4e9) == make_material("4GPa") == make_material(LinearHardening(4e9))
    assert make_material() == make_material(0.0)


def test_material_is_elastic_for_a_single_elastic_contact():
    material = make_material()
    assert material.compliance == rc.Elastic(210e9, 0.3).compliance
    assert material.pressure_limit == np.inf
    assert material.shear_modulus == pytest.approx(210e9 / 2.6)
    assert [law.of for law in material.bring_laws("counterbody")] == ["counterbody"]


def test_materials_come_from_files_by_their_names():
    material = rc.materials.create("plastic", young="210GPa", poisson=0.3, yield_stress="1GPa", hardening="4GPa")
    assert material == make_material("4GPa")


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Plastic("210GPa", 0.3, -1.0), "The yield stress"),
        (lambda: Plastic("210GPa", 0.3, "1m"), "The yield stress"),
        (lambda: Plastic("210GPa", 0.3, True), "The yield stress"),
        (lambda: Plastic("210GPa", 0.3, np.nan), "The yield stress"),
        (lambda: Plastic(0.0, 0.3, 1e9), "Young"),
        (lambda: Plastic("210GPa", 0.7, 1e9), "Poisson"),
        (lambda: make_material(-1.0), "hardening modulus"),
        (lambda: make_material([1.0]), "The hardening of a material"),
        (lambda: make_material(True), "The hardening of a material"),
        (lambda: make_material(accuracy=0.0), "accuracy"),
        (lambda: make_material(accuracy=2.0), "accuracy"),
        (lambda: SwiftHardening(0.0, 0.2), "strain over which"),
        (lambda: SwiftHardening(0.01, 1.5), "power"),
        (lambda: make_material(VoceHardening("0.5GPa", 0.1)), "at which hardening ends"),
        (lambda: TabulatedHardening([0.1], [1e9, 2e9]), "a stress for each strain"),
        (lambda: TabulatedHardening([], []), "a stress for each strain"),
        (lambda: TabulatedHardening([0.2, 0.1], [1e9, 2e9]), "must rise"),
        (lambda: TabulatedHardening([0.1, 0.2], [2e9, 1e9]), "softens"),
        (lambda: TabulatedHardening("abc", [2e9]), "plastic strain of a table"),
        (lambda: make_material(TabulatedHardening([0.1], [0.5e9])), "contradicts"),
        (lambda: make_material(TabulatedHardening([0.0], [2e9])), "contradicts"),
    ],
)
def test_refuses(make, sentence):
    with pytest.raises(rc.InputError, match=sentence):
        make()


def test_values_are_frozen():
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        make_material().poisson = 0.2


@pytest.mark.parametrize(
    ("name", "stress", "added", "power"),
    [
        ("OFHC-copper", 90e6, 292e6, 0.31),
        ("2024-T351-aluminium", 265e6, 426e6, 0.34),
        ("1006-steel", 350e6, 275e6, 0.36),
        ("4340-steel", 792e6, 510e6, 0.26),
    ],
)
def test_typical_metals_have_the_constants_of_johnson_and_cook(name, stress, added, power):
    material = rc.Body(rc.FlatSurface(), name).material
    for strain in (0.002, 0.1, 1.0):
        assert material.find_yield_stress(strain) == pytest.approx(stress + added * strain**power)


def test_the_return_from_a_fresh_material_whose_slope_is_steep():
    material = make_material(LudwikHardening("3GPa", power=0.05))
    trial = np.array([1.0 + 1e-9, 1.001, 1.5, 10.0]) * 1e9
    flow = find_multiplier(trial, np.zeros(4), material)
    assert np.all(flow > 0.0)
    assert trial - 3.0 * material.shear_modulus * flow == pytest.approx(material.find_yield_stress(flow), rel=1e-12)
