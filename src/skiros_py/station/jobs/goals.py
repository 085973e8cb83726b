"""Use cases: goals and goal templates. They are parsed and checked here; a job or a task pursues them."""

from __future__ import annotations

import hashlib

from skiros_py.api.goals import CheckedGoal, ConditionWords, GoalOrder, GoalTexts, SceneGoals
from skiros_py.api.templates import GoalTemplate, GoalTemplateContent, GoalTemplates
from skiros_py.errors import StaleVersion, UsageError
from skiros_py.skills.conditions.reads import ReadingView
from skiros_py.station.jobs.goal_checks import checked_goal, condition_words
from skiros_py.station.jobs.orders import texts_of
from skiros_py.station.jobs.templates import TemplateStore, check_template
from skiros_py.station.jobs.texts import goal_texts
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Service, addressed, require_seen
from skiros_py.world.change import Writer


class GoalService(Service):
    """Checks goals, and stores those of the scene."""

    def check(self, order: GoalOrder) -> CheckedGoal:
        """Returns the goal as parsed, and for each condition whether it holds now, or why not."""
        session = self._station.session
        version, state = session.world.state()
        view = ReadingView(state, session.world.sensors)  # one state of the world, with the present readings of devices
        return checked_goal(texts_of(order, self._station.template_store), view, version, session.catalogue.conditions)

    def get(self) -> SceneGoals:
        """Returns the goals of the scene."""
        session = self._station.session
        goals = session.world.goals
        try:
            session.parse(goals)
        except UsageError as error:
            return SceneGoals(goals=goals, fault=str(error))
        return SceneGoals(goals=goals)

    def put(self, body: GoalTexts, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY) -> SceneGoals:
        """Replaces the goals of the scene.

        Raises:
            UsageError: One of them cannot be parsed.
            StaleVersion: They were changed since the author has seen them.
        """
        world = self._station.session.world
        before = world.goals
        require_seen(seen, goals_version(before))
        texts = goal_texts(body.goals)
        self._station.session.parse(texts)
        with world.transaction(author.name, "the goals of the scene", writer=Writer.PERSON, holder=author.holder) as tx:
            if world.goals != before:
                raise StaleVersion("the goals of the scene were changed meanwhile: look again")
            tx.set_goals(texts)
        return self.get()

    def words(self, *, every: bool = False) -> ConditionWords:
        """Lists the words of goals, with the classes of their arguments.

        Args:
            every: True to include those that no present robot can fulfil.
        """
        session = self._station.session
        capabilities = self._station.control.call(lambda now: now.tasks.capabilities)
        words = condition_words(session.catalogue.conditions, capabilities, session.world.ontology)
        return ConditionWords(conditions=tuple(word for word in words if every or word.skills))


def goals_version(goals: tuple[str, ...]) -> int:
    """Returns a version number of the texts; the version of the world would change with every other edit."""
    return int.from_bytes(hashlib.sha256(repr(goals).encode()).digest()[:6])


class TemplateService(Service):
    """Goal templates, which ISA-95 calls work masters."""

    @property
    def _store(self) -> TemplateStore:
        return self._station.template_store

    def all(self) -> GoalTemplates:
        """Lists the goal templates, by name."""
        return GoalTemplates(templates=self._store.all())

    def get(self, name: str) -> GoalTemplate:
        """Returns a goal template.

        Raises:
            NotFound: There is none with this name.
        """
        with addressed():
            return self._store.find(name)

    def put(
        self, name: str, content: GoalTemplateContent, seen: Seen | None = ANY_VERSION
    ) -> tuple[GoalTemplate, bool]:
        """Writes a goal template; returns it, and True if it is new.

        Raises:
            UsageError: It cannot produce goals.
            StaleVersion: It was changed since it was seen.
        """
        session = self._station.session
        check_template(content, session.world.ontology, session.catalogue.conditions)
        known = self._store.get(name)
        if known is not None:
            require_seen(seen, known.version)
        return self._store.put(name, content, expects=0 if known is None else known.version), known is None

    def remove(self, name: str, seen: Seen | None = ANY_VERSION) -> None:
        """Removes a goal template; jobs ordered with it remain.

        Raises:
            NotFound: There is none with this name.
            StaleVersion: It was changed since it was seen.
        """
        known = self.get(name)
        require_seen(seen, known.version)
        self._store.remove(name, expects=known.version)
