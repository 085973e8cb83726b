"""The claims that every kind of device must keep."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

import dataclasses
import json
import math
import pickle
from abc import ABC, abstractmethod
from typing import Any

import pytest

from skiros_py.errors import DeviceError
from skiros_py.ports.device import DeviceModel, DeviceSpec, FakeRobot

_AT_REST = 400
"""Cycles after which a device without a target stands, at the latest."""


class DeviceKindContract(ABC):
    """Claims about a kind of device, tried on one device of it; what it does not have is skipped."""

    @abstractmethod
    def device(self) -> DeviceSpec[Any, Any]:
        """Returns a device of the kind."""

    def target(self) -> Any:
        """Returns a target that moves it; None for a sensor."""
        return None

    def test_it_has_a_name_and_a_class_of_the_ontology(self) -> None:
        device = self.device()

        assert device.kind
        assert device.device_class.partition(":")[2], "with its prefix, as in sk:Arm"

    def test_its_description_goes_to_other_processes(self) -> None:
        device = self.device()

        assert pickle.loads(pickle.dumps(device)) == device  # noqa: S301 - written just now

    def test_its_fake_says_states_of_its_type_and_stands_at_first(self) -> None:
        device = self.device()
        model = device.fake(FakeRobot())

        assert (model is None) == (device.state_type is None)
        if model is not None and device.state_type is not None:
            assert isinstance(model.state(), device.state_type)
            assert device.still(model.state())

    def test_its_fake_obeys_a_target_and_stands_without_one(self) -> None:
        device, target, model = self.device(), self._target(), self._model()
        model.command(target)
        moved = model.state()
        for _ in range(_AT_REST):
            model.command(None)

        assert moved != self._model().state()
        assert device.still(model.state())

    def test_what_is_no_target_is_refused_with_its_id(self) -> None:
        device = self.device()

        with pytest.raises(DeviceError, match=device.id):
            device.check("anything")

    def test_a_target_of_nothing_but_nan_is_refused(self) -> None:
        device, target = self.device(), self._target()
        device.check(target)

        with pytest.raises(DeviceError, match=device.id):
            device.check(_without_numbers(target))

    def test_states_and_targets_come_back_from_json_as_they_were(self) -> None:
        device, target = self.device(), self.target()
        state = None if device.state_type is None else self._model().state()

        if state is not None:
            assert device.decode_state(json.loads(json.dumps(device.encode(state)))) == state
        if target is not None:
            assert device.decode_target(json.loads(json.dumps(device.encode(target)))) == target

    def test_its_signals_have_names_of_their_own_and_finite_values(self) -> None:
        device = self.device()
        names = [signal.name for signal in device.signals]

        assert len(set(names)) == len(names)
        if device.state_type is not None:
            state = self._model().state()
            values = [signal.read(state) for signal in device.signals]
            assert all(math.isfinite(n) for v in values for n in (v if isinstance(v, tuple) else (v,)))

    def test_each_of_its_joints_has_a_position(self) -> None:
        device = self.device()

        assert len(device.joint_positions(self._model().state())) == len(device.joint_names)

    def test_its_target_at_full_rate_stays_as_it_is(self) -> None:
        target = self._target()

        assert self.device().scaled(target, 1.0) == target

    def _target(self) -> Any:
        target = self.target()
        return target if target is not None else pytest.skip("it takes no commands")

    def _model(self) -> DeviceModel:
        model = self.device().fake(FakeRobot())
        return model if model is not None else pytest.skip("it has no state")


def _without_numbers(target: Any) -> Any:
    """Returns a target of the same shape with NaN for every number."""
    values = {field.name: getattr(target, field.name) for field in dataclasses.fields(target)}
    spoilt = {name: (math.nan,) * len(v) if isinstance(v, tuple) else math.nan for name, v in values.items()}
    return dataclasses.replace(target, **spoilt)
