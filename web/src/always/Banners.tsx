import { useTranslation } from "react-i18next";
import classes from "./always.module.css";
import { ConnectionBanner } from "./ConnectionBanner";
import { HaltBanner } from "./HaltBanner";
import { QuestionBanners } from "./QuestionBanners";
import { StopVerdict } from "./StopVerdict";

/** Messages that must not be missed: a stop, a lost connection, a halt, questions to a person. */
export function Banners() {
  const { t } = useTranslation("always");
  return (
    <div>
      <StopVerdict />
      <section aria-label={t("banners")} className={classes.banners}>
        <ConnectionBanner />
        <HaltBanner />
        <QuestionBanners />
      </section>
    </div>
  );
}
