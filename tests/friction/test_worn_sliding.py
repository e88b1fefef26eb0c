"""Wear of bodies that slide steadily with friction: the pressure that wears is the one that their traction changes."""

import attrs
import numpy as np
import pytest

import roughcontact as rc

CAREFUL = rc.ProjectedConjugateGradient(tolerance=1e-9)
STEEL = rc.Elastic(210e9, 0.3)
# Of a rigid counterbody it has Dundurs' beta 0.5.
SOFT = rc.Elastic(1e9, 0.0)
UNLIKE = (SOFT, rc.Rigid())
FRICTION = 0.4
COEFFICIENT = 1e-13


def press_ball(shape=(15, 12), size=(1.5e-4, 1.2e-4), materials=UNLIKE, **parts):
    body = rc.Body(rc.ParaboloidSurface(radius=1e-3), materials[0])
    flat = rc.Body(rc.FlatSurface(), materials[1])
    parts.setdefault("laws", rc.Archard(COEFFICIENT))
    return rc.ContactProblem(body, flat, grid=rc.Grid(shape, size), **parts)


def press_rough(values, size, materials=UNLIKE, **parts):
    body = rc.Body(rc.HeightMap(values, size, periodic=True), materials[0])
    flat = rc.Body(rc.FlatSurface(), materials[1])
    parts.setdefault("laws", rc.Archard(COEFFICIENT))
    return rc.ContactProblem(body, flat, boundary="periodic", **parts)


def make_heights(shape=(24, 16), size=(1e-3, 5e-4), seed=4):
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2.5e-4, longest=1e-3, seed=seed)
    return rough.heights(rc.Grid(shape, size))


def worn(state, law=0):
    return next(one for one in state.added if one.kind == "laws").memory[law]["worn_height"]


def slide(problem, force=0.02, distances=(0.0, 0.5, 2.0), **options):
    return problem.path(force=force, sliding=distances, friction=FRICTION, **options)


@pytest.mark.parametrize("direction", [0.0, 180.0])
@pytest.mark.parametrize(("shape", "size"), [((32, 4), (1e-3, 1e-3)), ((33, 3), (1e-3, 3e-4))])
def test_a_wave_in_full_contact_wears_away_and_moves_along(shape, size, direction):
    """The pressure of a wave is its height over K (1 - i mu beta), so that the loss of height has a phase."""
    height, mean = 1e-6, 5e6
    grid = rc.Grid(shape, size)
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface((height, 0.0), size[0]), SOFT),
        rc.Body(rc.FlatSurface(), rc.Rigid()),
        grid=grid,
        boundary="periodic",
        solver=CAREFUL,
        laws=rc.Archard(COEFFICIENT),
    )
    q = 2.0 * np.pi / size[0]
    distance = 0.5 / (q * 1e9 / 2.0 * COEFFICIENT)
    path = problem.path(pressure=mean, sliding=[0.0, distance], friction=FRICTION, direction=direction, accuracy=1e-4)
    assert path[-1].contact.all()
    first, last = (np.fft.fft(state.pressure[:, 0])[1] for state in path)
    own = np.fft.fft(problem.displace(path[0].pressure)[:, 0])[1] / first
    # Of cells of uniform traction, over that of their pressure; beta of the half-spaces up to their width.
    lifted = np.fft.fft((path[0].initial_gap - problem.initial_gap)[:, 0])[1] / first
    beta = 0.5
    assert abs(lifted) / own.real == pytest.approx(FRICTION * beta, rel=0.02)
    assert abs((lifted / own).real) < 1e-3 * FRICTION * beta
    assert last / first == pytest.approx(np.exp(-COEFFICIENT * distance / (own + lifted)), rel=1e-3)
    # Ahead of a traction the surface moves into its body.
    assert (lifted / own).imag * (-1.0 if direction == 0.0 else 1.0) > 0.0


def solve_by_matrices(problem, force, distance, steps):
    """Return the heights lost in equal increments, by a dense set of cells in contact for each."""
    grid = problem.grid
    unit = np.eye(grid.cells)
    shape = grid.shape
    normal = np.stack([problem.displace(one.reshape(shape)).ravel() for one in unit], axis=1)
    fields = np.zeros((grid.cells, 2, *shape))
    fields[:, 0] = unit.reshape(-1, *shape)
    lifted = np.stack([problem.shear_convolution.apply(one, to="z")[0].ravel() for one in fields], axis=1)
    # Both maps are of tractions in the same unit: that of the pressure tells it.
    alone = problem.convolution.apply(unit[0].reshape(shape)).ravel()
    matrix = normal + FRICTION * lifted * (normal[0, 0] / alone[0])
    gap = problem.initial_gap.ravel()
    lost = np.zeros(grid.cells)
    pressure = np.zeros(grid.cells)
    touching = gap < 0.2 * gap.max()
    for number in range(steps + 1):
        wear = 0.5 * COEFFICIENT * distance / steps if number else 0.0
        offset = gap + lost + wear * pressure
        for _ in range(60):
            held = np.flatnonzero(touching)
            whole = np.zeros((held.size + 1, held.size + 1))
            whole[:-1, :-1] = matrix[np.ix_(held, held)] + wear * np.eye(held.size)
            whole[:-1, -1] = -1.0
            whole[-1, :-1] = grid.cell_area
            found = np.linalg.solve(whole, np.append(-offset[held], force))
            now = np.zeros(grid.cells)
            now[held] = found[:-1]
            opened = offset + matrix @ now + wear * now - found[-1]
            after = np.where(touching, now > 0.0, opened < 0.0)
            if (after == touching).all():
                break
            touching = after
        else:
            raise AssertionError("the set of cells in contact does not settle")
        lost += wear * (pressure + now)
        pressure = now
    return pressure.reshape(shape), lost.reshape(shape)


@pytest.mark.parametrize("materials", [(SOFT, rc.Rigid()), (rc.Rigid(), SOFT)])
def test_it_is_what_dense_matrices_find(materials):
    problem = press_ball(materials=materials)
    path = slide(problem, accuracy=3e-4)
    pressure, lost = solve_by_matrices(problem, 0.02, 2.0, 100)
    assert path[-1].contact.sum() > path[0].contact.sum()
    np.testing.assert_allclose(worn(path[-1]), lost, atol=2e-3 * lost.max())
    np.testing.assert_allclose(path[-1].pressure, pressure, atol=5e-3 * pressure.max())
    fresh, _ = solve_by_matrices(problem, 0.02, 0.0, 1)
    np.testing.assert_allclose(path[0].pressure, fresh, atol=1e-3 * fresh.max())
    # Friction matters here.
    alone = problem.path(force=0.02, sliding=[0.0, 0.5, 2.0])
    assert np.abs(worn(alone[-1]) - lost).max() > 0.02 * lost.max()


@pytest.mark.parametrize("boundary", ["free", "periodic", ("periodic", "free")])
@pytest.mark.parametrize("of", ["body", "counterbody"])
def test_the_volume_is_that_of_the_force_and_the_distance(boundary, of):
    problem = press_ball((20, 13), (2e-4, 3.9e-4), boundary=boundary, laws=rc.Archard(COEFFICIENT, of=of))
    path = slide(problem, force=[0.02, 0.01, 0.01], direction=30.0)
    volumes = path.table().columns["worn_volume"]
    assert volumes[1] == pytest.approx(COEFFICIENT * 0.5 * 0.015, rel=1e-9)
    assert volumes[2] == pytest.approx(COEFFICIENT * (0.5 * 0.015 + 1.5 * 0.01), rel=1e-9)
    path.verify()
    for state in path:
        assert state.certificate.error < 2e-5
        np.testing.assert_allclose(np.hypot(*state.shear), FRICTION * state.pressure, rtol=1e-12)


@pytest.mark.parametrize("given", [{"force": 0.02}, {"approach": 2e-6}])
def test_it_begins_with_the_state_of_steady_sliding(given):
    problem = press_ball()
    path = problem.path(**given, sliding=[0.0, 1.0], friction=FRICTION, direction=-20.0)
    alone = problem.slide(**given, friction=FRICTION, direction=-20.0)
    np.testing.assert_array_equal(path[0].pressure, alone.pressure)
    assert not worn(alone).any()
    assert path[1].is_steady
    path.verify()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_bodies_that_become_alike_wear_as_without_friction(boundary):
    found = []
    for young in (210e9, 209.99e9):
        other = rc.Elastic(young, 0.3)
        problem = press_ball(materials=(STEEL, other), boundary=boundary, laws=rc.Archard(1e-16))
        found.append(slide(problem, 1.0)[-1])
    frictionless = press_ball(materials=(STEEL, STEEL), boundary=boundary, laws=rc.Archard(1e-16)).path(
        force=1.0, sliding=[0.0, 0.5, 2.0]
    )[-1]
    np.testing.assert_array_equal(found[0].pressure, frictionless.pressure)
    np.testing.assert_array_equal(worn(found[0]), worn(frictionless))
    np.testing.assert_allclose(worn(found[1]), worn(frictionless), atol=1e-4 * worn(frictionless).max())


def test_turned_and_mirrored_bodies_wear_alike():
    size = (1e-3, 5e-4)
    heights = make_heights(size=size)
    turned = (size[1], size[0])
    mirrored = np.roll(heights[::-1], 1, axis=0)

    def wear(values, sides, direction):
        path = press_rough(values, sides, solver=CAREFUL).path(
            pressure=2e6, sliding=[0.0, 2.0], friction=FRICTION, direction=direction
        )
        return worn(path[-1]), path.increments[-1]

    lost, count = wear(heights, size, 0.0)
    for values, sides, direction, back in (
        (heights.T, turned, 90.0, lambda field: field.T),
        (mirrored, size, 180.0, lambda field: np.roll(field[::-1], 1, axis=0)),
    ):
        other, others = wear(values, sides, direction)
        assert others == count
        np.testing.assert_allclose(back(other), lost, atol=1e-6 * lost.max())
    opposite, _ = wear(heights, size, 180.0)
    assert np.abs(opposite - lost).max() > 1e-2 * lost.max()


def test_units_by_powers_of_two_change_no_bit():
    found = []
    for scale in (1.0, 2.0**30):
        materials = (rc.Elastic(1e9 * scale, 0.0), rc.Rigid())
        problem = press_ball(materials=materials, laws=rc.Archard(COEFFICIENT / scale))
        found.append(worn(slide(problem, 0.02 * scale)[-1]))
    np.testing.assert_array_equal(*found)


def test_less_strict_increments_change_little():
    problem = press_ball()
    coarse, fine = (worn(slide(problem, accuracy=accuracy)[-1]) for accuracy in (1e-3, 2.5e-4))
    np.testing.assert_allclose(coarse, fine, atol=3e-3 * fine.max())


def test_wear_and_flattening_act_together():
    soft = rc.ElasticPerfectlyPlastic(young=1e9, poisson=0.0, hardness=4e6)
    path = slide(press_ball(materials=(soft, rc.Rigid())), force=[0.02, 0.02, 0.0], direction=90.0)
    columns = path.table().columns
    assert columns["flattened_volume"][0] > 0.0
    assert columns["worn_volume"][1] == pytest.approx(COEFFICIENT * 0.5 * 0.02, rel=1e-9)
    assert not path[-1].pressure.any()
    path.verify()


def test_a_law_with_a_limit_is_followed():
    problem = press_ball()
    law = rc.LimitedCoulomb(0.4, 1e6)
    path = problem.path(force=0.02, sliding=[0.0, 1.0], friction=law)
    assert np.hypot(*path[-1].shear).max() == pytest.approx(1e6)
    assert path[-1].friction == law
    path.verify()


class TestFiles:
    """Paths that are saved, continued, and written while they grow."""

    def test_a_path_comes_back_and_goes_on(self, tmp_path):
        problem = press_ball()
        whole = slide(problem, direction=30.0)
        first = slide(problem, distances=[0.0, 0.5], direction=30.0)
        first.save(tmp_path / "path.npz")
        read = rc.load(tmp_path / "path.npz")
        assert str(read) == str(first)
        for one in (first, read):
            more = one.extend(force=0.02, sliding=[2.0])
            assert len(more) == 3
            np.testing.assert_allclose(worn(more[-1]), worn(whole[-1]), atol=2e-3 * worn(whole[-1]).max())
            assert more[-1].tangential_load == whole[-1].tangential_load
        arguments = whole.list_arguments()
        assert arguments["direction"] == 30.0
        again = problem.path(**arguments)
        np.testing.assert_array_equal(again[-1].pressure, whole[-1].pressure)

    def test_a_file_that_grows_goes_on_to_the_same_bits(self, tmp_path):
        problem = press_ball()
        whole = slide(problem)
        file = tmp_path / "growing.npz"
        told = []

        def stop(state):
            told.append(state)
            if len(told) == 6:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            slide(problem, file=file, on_increment=stop)
        again = slide(problem, file=file)
        np.testing.assert_array_equal(again[-1].pressure, whole[-1].pressure)
        np.testing.assert_array_equal(worn(again[-1]), worn(whole[-1]))
        assert again.convolutions == whole.convolutions
        with pytest.raises(rc.InputError, match="another problem or along other places"):
            slide(problem, file=file, direction=90.0)

    def test_another_height_is_noticed(self):
        path = slide(press_ball())
        last = path[-1]
        effect = next(one for one in last.added if one.kind == "laws")
        memory = dict(effect.memory[0])
        memory["worn_height"] = memory["worn_height"] * (1.0 + 1e-6)
        changed = last._add(attrs.evolve(effect, memory=(memory,)))
        with pytest.raises(rc.InputError, match="worn_height"):
            changed.verify()


@pytest.mark.parametrize(
    ("laws", "options", "said"),
    [
        (rc.Archard(1e-13), {"tangential_force": (0.1, 0.0)}, "tangential_force= .* only without sliding="),
        (rc.Archard(1e-13), {"cycles": [1, 2]}, "cycles= .* only without sliding="),
        (rc.Archard(1e-13), {"shift": [(0, 0), (1, 0)]}, "shift= .* only without friction"),
        (rc.EnergyWear(1e-13), {}, "EnergyWear.* has no slip"),
        ((), {}, "Nothing changes with the sliding distance"),
        (rc.Archard(1e-13), {"friction": 3.0}, "beta is 1.5"),
        (rc.Archard(1e-13), {"friction": 3.0, "force": [0.01, 0.02], "sliding": [1.0, 2.0]}, "beta is 1.5"),
        (rc.Archard(1e-13), {"friction": None, "direction": 10.0}, "direction= .* only with friction"),
        (rc.Archard(1e-13), {"sliding": None, "direction": 10.0}, "direction= .* only where bodies slide"),
        (rc.Archard(1e-13), {"direction": "left"}, "direction of sliding"),
    ],
)
def test_what_does_not_fit_gets_a_sentence(laws, options, said):
    given = {"force": 0.02, "sliding": [0.0, 1.0], "friction": FRICTION, **options}
    with pytest.raises(rc.InputError, match=said):
        press_ball(laws=laws).path(**given)
