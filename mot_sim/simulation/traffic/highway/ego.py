"""The car that carries the camera: it drives itself until it is told what to do."""

from numpy import cos

from mot_sim.simulation.traffic.driving import Driving
from mot_sim.simulation.traffic.highway.car import FASTEST, HARDEST, TICK, Car

# m/s a command: at 10 commands a second the rate of highway-env, 5 m/s a second.
SPEED_STEP = 0.5
FARTHEST_ASIDE = 0.5  # of a lane's width


class EgoCar(Car):
    """The ego car. Under command it follows its lane and holds a speed, whoever is in its way:
    it neither yields nor brakes for others, as highway-env's MDPVehicle.
    """

    told_speed: float | None = None  # m/s; None: it drives itself

    def obey(self, command: str) -> None:
        """Take a command of COMMANDS; a lane that is not there, or one more while it changes
        lanes, changes nothing but who drives."""
        if command == "autopilot":
            self.told_speed = None
            return
        told = float(self.speed) if self.told_speed is None else self.told_speed
        told += {"faster": SPEED_STEP, "slower": -SPEED_STEP}.get(command, 0.0)
        self.told_speed = min(max(told, 0.0), FASTEST)
        aside = {"lane_left": -1, "lane_right": 1}.get(command, 0)
        if aside and self.lane_index == self.target_lane_index:
            beside = (*self.lane_index[:2], self.lane_index[2] + aside)
            if beside in self.road.beside(self.lane_index):
                self.target_lane_index = beside

    def act(self, action: object = None) -> None:
        """Steering and acceleration for the next tick."""
        if self.crashed or self.told_speed is None:
            super().act(action)
            return
        wanted = self.KP_A * (self.told_speed - self.speed)
        wanted = max(min(wanted, self.ACC_MAX), -HARDEST, -self.speed / TICK)
        self.action = {"steering": self.steering(), "acceleration": float(wanted)}

    def driving(self, touches: bool) -> Driving:
        """How it drives now; touches: whether it overlaps another car."""
        turned = self.heading - float(self.lane.heading_at(self.along))
        return Driving(
            speed=float(self.speed * cos(turned)),
            limit=float(self.lane.speed_limit),
            lane=int(self.lane_index[2]),
            lanes=len(self.road.beside(self.lane_index)),
            on_road=abs(self.aside) <= FARTHEST_ASIDE * float(self.lane.width_at(self.along)),
            crashed=bool(self.crashed) or touches,
        )
